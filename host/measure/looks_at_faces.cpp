// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/inspect/point_grid.hpp"
#include "host/measure/doubts.hpp"
#include "host/measure/points_to_decide.hpp"
#include "host/plan/order_views.hpp"

namespace tetragauge {
namespace {

// A face is gone back to when so much more of it could be seen.
constexpr double kWorthwhileShare = 0.05;
// Beams one pitch apart lie up to this many pitches apart on a face at 65 degrees.
constexpr double kCoveredPitches = 2.5;
// Finer than the spot is not worth having.
constexpr double kFinestUseful_mm = 0.1;
// What two looks did not show, a third will not.
constexpr int kMostLooks = 2;

bool is_wanted(const FaceLooksInput& in, const Face& face) {
  // Nothing held against a datum is decided without it.
  const std::vector<Datum>& datums = in.tolerances.datums;
  const bool is_datum =
      std::any_of(datums.begin(), datums.end(), [&](const Datum& datum) { return datum.face == face.id; });
  if (is_datum) return true;
  if (in.tolerances.skip.contains(face.id)) return false;
  return !in.tolerances.given || has_tolerance(in.tolerances.of(face));
}

class Looker {
 public:
  explicit Looker(const FaceLooksInput& in) : in_(in), patches_(face_patches(in.model, in.caster)) {
    const RigidTransform T_model_part = in.T_part_model.inverse();
    for (const Vec3& p : in.points_mm) points_.push_back(T_model_part * p);
  }

  // The face's patches that no point lies near to, or all of them.
  std::vector<Patch> patches_of(size_t face, bool only_uncovered) const {
    const double near = kCoveredPitches * in_.options.pitch_mm;
    if (only_uncovered && !grid_) grid_.emplace(points_, near);
    std::vector<Patch> out;
    for (const Patch& patch : patches_) {
      if (static_cast<size_t>(patch.face) != face) continue;
      if (only_uncovered && grid_->any_within(patch.point_mm, near)) continue;
      out.push_back(patch);
    }
    return out;
  }

  // Rasters over what of the patches can be seen, if that is `least_share` of the face's area.
  std::vector<PlannedView> look(const std::vector<Patch>& patches, double area_mm2, double least_share,
                                double most_pitch_mm) const {
    if (patches.empty()) return {};
    const double max_incidence = in_.options.max_incidence_deg * std::numbers::pi / 180;
    const SightSurvey survey =
        survey_sights(in_.machine, in_.caster, in_.T_part_model, patches, max_incidence);
    std::vector<bool> wanted(patches.size());
    double seen = 0;
    for (size_t k = 0; k < patches.size(); ++k) {
      wanted[k] = survey.outlooks[k].is_seen_well || survey.outlooks[k].is_seen_flat;
      if (wanted[k]) seen += patches[k].area_mm2;
    }
    if (!(seen > 0) || seen < least_share * area_mm2) return {};
    // Enough points even when the beam comes flat.
    const double share = std::min(1.0, seen / std::max(1e-9, area_mm2));
    const double for_points =
        std::sqrt(0.5 * seen / (share * static_cast<double>(in_.options.points_per_face)));
    const double pitch =
        std::max(kFinestUseful_mm,
                 std::floor(100 * std::min({most_pitch_mm, for_points, in_.options.pitch_mm})) / 100);
    const ViewCost cost = view_cost(in_.machine, pitch, in_.options.samples);
    std::vector<PlannedView> views;
    for (const ChosenView& chosen : choose_views(survey, patches, wanted, cost)) {
      const CandidateView& from = survey.candidates[chosen.candidate];
      for (const RasterWindow& window :
           lay_windows(window_spots(from, chosen.sights, patches), cost.raster).windows)
        views.push_back({from.place.table_deg, from.place.slide_mm, window, pitch, in_.options.samples});
    }
    return views;
  }

 private:
  const FaceLooksInput& in_;
  std::vector<Patch> patches_;
  std::vector<Vec3> points_;
  mutable std::optional<PointGrid> grid_;
};

// All windows of a place together, places on the shortest way.
ScanPlan ordered(const PlanningMachine& machine, const std::vector<PlannedView>& views,
                 const MachineStance& stance) {
  std::vector<StagePlace> places;
  for (const PlannedView& view : views) {
    const bool known = std::any_of(places.begin(), places.end(), [&](const StagePlace& place) {
      return place.table_deg == view.table_deg && place.slide_mm == view.slide_mm;
    });
    if (!known) places.push_back({view.table_deg, view.slide_mm});
  }
  ScanPlan plan;
  for (const size_t k : order_views(machine, places, stance))
    for (const PlannedView& view : views)
      if (view.table_deg == places[k].table_deg && view.slide_mm == places[k].slide_mm)
        plan.views.push_back(view);
  return plan;
}

}  // namespace

FaceLooks looks_at_faces(const FaceLooksInput& in, const MachineStance& stance) {
  const Looker looker(in);
  const std::map<int, double> times = points_to_decide(in.inspection, in.model, in.tolerances, in.u_cal_mm);
  FaceLooks out;
  std::vector<PlannedView> all;
  for (size_t f = 0; f < in.model.faces().size(); ++f) {
    const Face& face = in.model.faces()[f];
    const FaceInspection& found = in.inspection.faces[f];
    const std::vector<int>& missing = in.inspection.missing_faces;
    if (std::find(missing.begin(), missing.end(), face.id) != missing.end()) continue;
    if (in.looked_at.contains(face.id) && in.looked_at.at(face.id) >= kMostLooks) continue;
    if (const auto more = times.find(face.id); more != times.end()) {
      const double pitch_mm = in.options.pitch_mm / std::sqrt(more->second);
      const auto views = looker.look(looker.patches_of(f, false), face.area_mm2, 0, pitch_mm);
      if (views.empty()) continue;
      all.insert(all.end(), views.begin(), views.end());
      out.undecided.push_back(face.id);
      continue;
    }
    // What is out of tolerance is no doubt.
    if (!is_wanted(in, face) || found.verdict == Verdict::fail) continue;
    const double least_share = found.measured ? kWorthwhileShare : 0;
    const auto views =
        looker.look(looker.patches_of(f, true), face.area_mm2, least_share, in.options.pitch_mm);
    if (views.empty()) continue;
    all.insert(all.end(), views.begin(), views.end());
    out.uncovered.push_back(face.id);
  }
  out.views = ordered(in.machine, all, stance);
  return out;
}

void drop_cut_spots(const FaceLooksInput& in, const ScanPlan& views, Scan& scan) {
  const RigidTransform T_model_part = in.T_part_model.inverse();
  std::vector<HeadOverPart> heads;
  for (const PlannedView& view : views.views)
    heads.emplace_back(in.machine, in.T_part_model, StagePlace{view.table_deg, view.slide_mm});
  std::vector<uint8_t> is_kept(scan.size(), 1);
  tbb::parallel_for(size_t{0}, scan.size(), [&](size_t i) {
    const Vec3 origin = T_model_part * scan.ray_origins[i];
    const MachineRay ray{origin, (T_model_part * scan.points[i] - origin).normalized()};
    const auto hit = in.caster.first_hit(ray.origin_mm, ray.direction);
    // Where the model has nothing the part has something: that is kept.
    is_kept[i] = !hit || heads[scan.view[i]].is_clear(in.caster, ray, *hit);
  });
  const auto keep = [&](auto& values) {
    size_t kept = 0;
    for (size_t i = 0; i < values.size(); ++i)
      if (is_kept[i]) values[kept++] = values[i];
    values.resize(kept);
  };
  keep(scan.points);
  keep(scan.ray_origins);
  keep(scan.sigma_mm);
  keep(scan.intensity);
  keep(scan.view);
  keep(scan.flags);
}

}  // namespace tetragauge
