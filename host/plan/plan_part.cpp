// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/plan_part.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <numeric>

#include "host/plan/forecast_view.hpp"
#include "host/plan/order_views.hpp"

namespace tetragauge {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// The finest raster worth having: the spot is 0.16 mm across.
constexpr double kFinestUseful_mm = 0.1;
// Light from both sides of an edge spoils a point here and there.
constexpr double kSpareShare = 0.25;
constexpr int kMostRefinements = 4;

std::string degrees(double deg) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f degrees", deg);
  return text;
}

std::string in_words(const FaceOutlook& face, double normal_z, double max_incidence_deg) {
  switch (face.obstacle) {
    case Obstacle::turned_away:
      return normal_z < -0.5 ? "underside: it looks down, and the beam comes from above"
                             : "no view looks at it: it is turned away from the beam at every table angle";
    case Obstacle::out_of_reach:
      return "outside the reach of the mirrors or the working volume";
    case Obstacle::out_of_sight:
      return "outside what the cameras see";
    case Obstacle::beam_blocked:
      return "occluded: other material is in the beam's way from every view";
    case Obstacle::cameras_blocked:
      return "occluded: other material hides the spot from both cameras in every view";
    case Obstacle::none:
      return "incidence: it is seen at " + degrees(face.least_incidence_deg) + " at best, " +
             degrees(max_incidence_deg) + " allowed";
  }
  return "";
}

std::vector<FaceOutlook> outlook_of_faces(const Solid& model, const RigidTransform& T_part_model,
                                          std::span<const Patch> patches, const SightSurvey& survey,
                                          const PlanPartOptions& options) {
  std::vector<FaceOutlook> faces(model.faces().size());
  std::vector<double> area(faces.size(), 0.0), normal_z(faces.size(), 0.0);
  for (FaceOutlook& face : faces) face.obstacle = Obstacle::turned_away;
  for (size_t k = 0; k < patches.size(); ++k) {
    const auto f = static_cast<size_t>(patches[k].face);
    const PatchOutlook& outlook = survey.outlooks[k];
    area[f] += patches[k].area_mm2;
    normal_z[f] += patches[k].area_mm2 * (T_part_model.R * patches[k].normal).z();
    // A corner's spot is no area: it may peep out where the face does not.
    if (!(patches[k].area_mm2 > 0)) continue;
    FaceOutlook& face = faces[f];
    face.obstacle = std::max(face.obstacle, outlook.obstacle);
    face.least_incidence_deg = std::min(face.least_incidence_deg, outlook.least_incidence_rad / kDegree);
    if (outlook.is_seen_flat) face.flat_share += patches[k].area_mm2;
    if (!outlook.is_seen_well) continue;
    face.is_seen = true;
    face.visible_share += patches[k].area_mm2;
  }
  for (size_t f = 0; f < faces.size(); ++f) {
    faces[f].id = model.faces()[f].id;
    if (area[f] > 0) {
      faces[f].visible_share /= area[f];
      faces[f].flat_share /= area[f];
    }
    if (!faces[f].is_seen)
      faces[f].why = in_words(faces[f], area[f] > 0 ? normal_z[f] / area[f] : 0, options.max_incidence_deg);
  }
  return faces;
}

PlannedView planned(const CandidateView& place, const RasterWindow& window, double pitch_mm,
                    uint32_t samples) {
  return {place.place.table_deg, place.place.slide_mm, window, pitch_mm, samples};
}

// Views that give face f its points: a raster of its own from the place that sees most of it, one already
// in use if that sees half as much.
class FaceRefiner {
 public:
  FaceRefiner(const PlanningMachine& machine, const SightSurvey& survey, std::span<const Patch> patches,
              size_t faces, const PlanPartOptions& options)
      : machine_(machine), survey_(survey), patches_(patches), options_(options) {
    for (const CandidateView& view : survey.candidates) {
      std::vector<double>& areas = seen_mm2_.emplace_back(faces, 0.0);
      for (const PatchSight& sight : view.sights)
        areas[static_cast<size_t>(patches[sight.patch].face)] +=
            patches[sight.patch].area_mm2 * static_cast<double>(sight.cosine);
    }
  }

  struct Refinement {
    size_t candidate = 0;
    std::vector<PlannedView> views;
  };
  Refinement refine(size_t face, const std::vector<bool>& in_use, double finer) const {
    size_t best = 0, best_used = 0;
    double most = 0, most_used = 0;
    for (size_t c = 0; c < survey_.candidates.size(); ++c) {
      const double seen = seen_area(face, c);
      if (seen > most) std::tie(most, best) = std::pair(seen, c);
      if (in_use[c] && seen > most_used) std::tie(most_used, best_used) = std::pair(seen, c);
    }
    Refinement out;
    out.candidate = 2 * most_used >= most ? best_used : best;
    const CandidateView& place = survey_.candidates[out.candidate];
    const double pitch =
        std::clamp(finer * std::sqrt(seen_area(face, out.candidate) /
                                     ((1 + kSpareShare) * static_cast<double>(options_.points_per_face))),
                   kFinestUseful_mm, options_.pitch_mm);
    std::vector<uint32_t> sights;
    for (uint32_t s = 0; s < place.sights.size(); ++s)
      if (static_cast<size_t>(patches_[place.sights[s].patch].face) == face) sights.push_back(s);
    const WindowLayout layout =
        lay_windows(window_spots(place, sights, patches_), raster_cost(machine_, pitch, options_.samples));
    for (const RasterWindow& window : layout.windows)
      out.views.push_back(planned(place, window, std::floor(100 * pitch) / 100, options_.samples));
    return out;
  }

 private:
  double seen_area(size_t face, size_t candidate) const { return seen_mm2_[candidate][face]; }

  const PlanningMachine& machine_;
  const SightSurvey& survey_;
  std::span<const Patch> patches_;
  const PlanPartOptions& options_;
  std::vector<std::vector<double>> seen_mm2_;  // by candidate and face, as the beam sees it
};

}  // namespace

Result<PartPlan> plan_part(const PlanningMachine& machine, const Solid& model, const RayCaster& caster,
                           const RigidTransform& T_part_model, const PlanPartOptions& options,
                           const MachineStance& stance) {
  const double max_incidence_rad = options.max_incidence_deg * kDegree;
  const std::vector<Patch> patches = face_patches(model, caster);
  const SightSurvey survey = survey_sights(machine, caster, T_part_model, patches, max_incidence_rad);
  PartPlan plan;
  plan.faces = outlook_of_faces(model, T_part_model, patches, survey, options);
  if (std::none_of(plan.faces.begin(), plan.faces.end(), [](const FaceOutlook& f) { return f.is_seen; })) {
    return bad_input("no face of the part can be seen by the machine as it stands (face 1: " +
                     plan.faces.front().why + "); check the pose and the model's unit");
  }

  // Everything that can be seen, at the pitch asked for ...
  std::vector<bool> wanted(patches.size());
  for (size_t k = 0; k < patches.size(); ++k)
    wanted[k] = survey.outlooks[k].is_seen_well || survey.outlooks[k].is_seen_flat;
  const ViewCost cost = view_cost(machine, options.pitch_mm, options.samples);
  std::map<size_t, std::vector<PlannedView>> views;  // by candidate
  std::vector<bool> in_use(survey.candidates.size(), false);
  const auto forecast = [&](const PlannedView& view) -> Status {
    const auto points =
        forecast_view(machine, caster, plan.faces.size(), T_part_model, view, max_incidence_rad);
    if (!points) return points.error();
    for (size_t f = 0; f < plan.faces.size(); ++f) plan.faces[f].points += (*points)[f];
    return Done{};
  };
  const std::vector<ChosenView> chosen_views = choose_views(survey, patches, wanted, cost);
  size_t count = 0;
  for (const ChosenView& chosen : chosen_views) {
    const CandidateView& place = survey.candidates[chosen.candidate];
    const std::vector<WindowSpot> spots = window_spots(place, chosen.sights, patches);
    WindowLayout layout = lay_windows(spots, cost.raster);
    // Half of what the machine holds is for these, one window each if need be.
    if (count + layout.windows.size() + chosen_views.size() > machine.max_views / 2)
      layout.windows = {window_around(spots, cost.raster)};
    count += layout.windows.size();
    in_use[chosen.candidate] = true;
    for (const RasterWindow& window : layout.windows) {
      const PlannedView view = planned(place, window, options.pitch_mm, options.samples);
      if (const Status done = forecast(view); !done) return done.error();
      views[chosen.candidate].push_back(view);
    }
  }

  // ... and finer where a face would get too few points of it.
  const FaceRefiner refiner(machine, survey, patches, plan.faces.size(), options);
  const auto enough = static_cast<size_t>((1 + kSpareShare) * static_cast<double>(options.points_per_face));
  for (size_t f = 0; f < plan.faces.size(); ++f) {
    double finer = 1;
    for (int k = 0; k < kMostRefinements && plan.faces[f].is_seen && plan.faces[f].points < enough; ++k) {
      const FaceRefiner::Refinement more = refiner.refine(f, in_use, finer);
      if (count + more.views.size() > machine.max_views) break;
      count += more.views.size();
      in_use[more.candidate] = true;
      for (const PlannedView& view : more.views) {
        if (const Status done = forecast(view); !done) return done.error();
        views[more.candidate].push_back(view);
      }
      finer *= 0.7;
    }
  }

  std::vector<StagePlace> places;
  std::vector<const std::vector<PlannedView>*> of_place;
  for (const auto& [candidate, at_place] : views) {
    places.push_back(survey.candidates[candidate].place);
    of_place.push_back(&at_place);
  }
  for (const size_t k : order_views(machine, places, stance))
    plan.scan.views.insert(plan.scan.views.end(), of_place[k]->begin(), of_place[k]->end());
  plan.places = places.size();
  if (plan.scan.views.size() > machine.max_views) {
    return bad_input("the plan would need " + std::to_string(plan.scan.views.size()) +
                     " views, the machine takes " + std::to_string(machine.max_views) +
                     "; ask for fewer points or a coarser pitch");
  }
  const auto time_s = plan_time_s(machine, plan.scan, stance);
  if (!time_s) return time_s.error();
  plan.time_s = *time_s;
  return plan;
}

}  // namespace tetragauge
