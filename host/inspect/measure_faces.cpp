// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/measure_faces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/inspect/measure_face.hpp"
#include "host/solid/surface_crossings.hpp"

namespace tetragauge {
namespace {

// What the rays that should have met a face found.
struct Sight {
  std::vector<uint32_t> on;  // points of the face
  size_t met = 0;            // rays that should have met it
  size_t behind = 0;         // went clearly through where its material should be
  size_t covered = 0;        // ended before it, where another face of the part goes on over it
  size_t elsewhere = 0;      // points at another surface or off by more than the gate
};

// A point clearly off this face that lies much nearer to a neighbour's surface: the neighbour is out of place
// and so is their edge.
bool is_of_neighbour(const Solid& model, const Face& face, const Vec3& point_mm, double deviation_mm,
                     double sigma_mm) {
  if (std::abs(deviation_mm) <= 3 * sigma_mm) return false;
  return std::any_of(face.neighbours.begin(), face.neighbours.end(), [&](int id) {
    const Face& other = model.faces()[static_cast<size_t>(id) - 1];
    return has_crossings(other) &&
           std::abs(distance_to_surface(other, point_mm)) < 0.5 * std::abs(deviation_mm);
  });
}

// A measured face's points belong to its model face's surface; among patches of one surface the ray decides.
// A point on no paired measured face belongs to the model face that its ray meets, if it lies near. Rays that
// meet another face than their point's are at an edge, and left out.
std::vector<Sight> sort_points(const Solid& model, const JoinedScan& joined) {
  const CastScan& cast = joined.cast;
  std::vector<int> surface_of_point(cast.face.size(), 0);
  std::vector<bool> paired(model.faces().size(), false);
  for (const MeasuredPatch& patch : joined.patches) {
    if (patch.model_id == 0) continue;
    const size_t face = static_cast<size_t>(patch.model_id) - 1;
    paired[face] = true;
    for (const uint32_t i : patch.points) surface_of_point[i] = model.faces()[face].surface;
  }
  std::vector<Sight> sights(model.faces().size());
  for (uint32_t i = 0; i < cast.face.size(); ++i) {
    if (cast.face[i] < 0) continue;
    const size_t face = static_cast<size_t>(cast.face[i]);
    Sight& sight = sights[face];
    ++sight.met;
    const bool near = std::abs(cast.deviation_mm[i]) <= joined.max_offset_mm;
    const bool of_this = surface_of_point[i] == model.faces()[face].surface;
    if (of_this || (near && surface_of_point[i] == 0 && !paired[face] &&
                    !is_of_neighbour(model, model.faces()[face], cast.points_mm[i], cast.deviation_mm[i],
                                     cast.sigma_mm[i]))) {
      sight.on.push_back(i);
    } else {
      ++sight.elsewhere;
      if (!near && cast.beyond_mm[i] > joined.max_offset_mm) ++sight.behind;
      // Whose point it is has been decided: within the gate, too, it may be another face's.
      const bool is_off = std::abs(cast.deviation_mm[i]) > 3 * cast.sigma_mm[i];
      if (surface_of_point[i] != 0 && cast.beyond_mm[i] < 0 && is_off) ++sight.covered;
    }
  }
  return sights;
}

// By weight in a fit: the set-ups' parts in the sum of 1/sigma^2.
std::vector<double> share_of_set_ups(const JoinedScan& joined, const std::vector<uint32_t>& points,
                                     size_t set_ups) {
  std::vector<double> share(set_ups, 0.0);
  double total = 0;
  for (const uint32_t i : points) {
    const double sigma = std::max(1e-6, joined.cast.sigma_mm[i]);
    share[joined.set_up[i]] += 1 / (sigma * sigma);
    total += 1 / (sigma * sigma);
  }
  if (total > 0)
    for (double& part : share) part /= total;
  return share;
}

std::string in_words(const char* format, double a, double b = 0) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, a, b);
  return text.data();
}

std::string why_absent(const Sight& sight) {
  const double met = static_cast<double>(sight.met), behind = static_cast<double>(sight.behind),
               covered = static_cast<double>(sight.covered);
  const std::string who = in_words("rays prove it absent: of %.0f ", met);
  if (sight.covered == 0) return who + in_words("%.0f went through its place", behind);
  if (sight.behind == 0) return who + in_words("%.0f ended on a face that goes on over it", covered);
  return who + in_words("%.0f went through its place and %.0f ended on a face that goes on over it", behind,
                        covered);
}

// Flatness and profile ask for form; orientation holds it too.
double form_tolerance(const FaceTolerance& tolerance) {
  double tightest = 1e300;
  for (const auto& limit : {tolerance.flatness_mm, tolerance.profile_mm})
    if (limit) tightest = std::min(tightest, *limit);
  for (const auto& limit : {tolerance.parallelism_mm, tolerance.perpendicularity_mm, tolerance.position_mm})
    if (limit) tightest = std::min(tightest, limit->value);
  return tightest < 1e300 ? tightest : 0;
}

void measure(const Sight& sight, const FaceMeasurement& in, bool is_held, double min_coverage,
             FaceInspection& out) {
  out.points_used = sight.on.size();
  out.points_rejected = sight.elsewhere;
  if (sight.on.size() < kLeastPoints) {
    out.reason = in_words("not seen: %.0f points", static_cast<double>(sight.on.size()));
    return;
  }
  measure_face(in, out);
  if (!is_held) {
    out.measured = false;
    out.reason = "the part's pose is undetermined, and with it where this face should be";
  } else if (!out.measured) {
    if (out.reason.empty()) out.reason = "its points lie on a line";
  } else if (out.coverage < min_coverage) {
    out.measured = false;
    out.reason = in_words("%.0f %% of its area seen, %.0f %% wanted", 100 * out.coverage, 100 * min_coverage);
  }
}

// On the model's curved face, or on where that one was found to lie.
bool is_of_curve(const Face& face, const FaceInspection& measured, const CastScan& cast, uint32_t i) {
  const double limit = 3 * cast.sigma_mm[i], deviation = cast.deviation_mm[i];
  return std::abs(deviation) <= limit ||
         std::abs(deviation_as_measured(face, measured, cast.points_mm[i], deviation)) <= limit;
}

}  // namespace

MeasuredPart measure_faces(const JoinedScan& joined, const Solid& model, const RayCaster& caster,
                           const std::vector<FaceOutline>& outlines, const PartPose& pose,
                           const Tolerances& tolerances) {
  const CastScan& cast = joined.cast;
  const std::vector<Sight> sights = sort_points(model, joined);
  MeasuredPart part;
  part.point_deviation_mm.assign(cast.face.size(), 0.0f);
  part.point_face.assign(cast.face.size(), 0);
  for (size_t i = 0; i < cast.face.size(); ++i)
    if (cast.face[i] >= 0) part.point_deviation_mm[i] = static_cast<float>(cast.deviation_mm[i]);

  for (size_t k = 0; k < model.faces().size(); ++k) {
    const Face& face = model.faces()[k];
    const Sight& sight = sights[k];
    const FaceTolerance tolerance = tolerances.of(face);
    const bool wanted = has_tolerance(tolerance) && !tolerances.skip.contains(face.id);
    FaceInspection out;
    out.model_id = face.id;
    double area_mm2 = 0;
    for (const MeasuredPatch& patch : joined.patches) {
      if (patch.model_id != face.id) continue;
      if (out.measured_id == 0) out.measured_id = patch.measured_id;
      area_mm2 += patch.area_mm2;
    }
    for (const uint32_t i : sight.on) part.point_face[i] = face.id;
    part.share.push_back(share_of_set_ups(joined, sight.on, pose.covariances.size()));

    // Most of the rays went through, or ended on the part's own surface over it, and hardly one found it: it
    // is not there. Something else in the way, a fixture say, only hides it. Where it should be must be
    // known.
    const bool absent = out.measured_id == 0 && sight.met >= kLeastPoints &&
                        2 * (sight.behind + sight.covered) > sight.met && 5 * sight.on.size() < sight.met &&
                        joined.held[k] && !joined.is_free_to_shift;
    if (absent) {
      part.missing.push_back(face.id);
      if (wanted) out.verdict = Verdict::fail;
      out.points_used = sight.on.size();
      out.points_rejected = sight.elsewhere;
      out.reason = why_absent(sight);
    } else {
      const PoseError pose_error = pose.error(part.share.back(), face.id);
      measure(sight,
              {face, outlines[k], caster, cast, pose_error, sight.on, area_mm2, form_tolerance(tolerance),
               joined.u_cal_mm, joined.spot_mm},
              joined.held[k], tolerances.min_coverage, out);
      if (wanted && !out.measured) out.verdict = Verdict::not_measured;
      if (face.type == SurfaceType::other && out.measured)
        out.reason = "free-form: compared point by point, not fitted";
    }
    part.faces.push_back(std::move(out));
  }
  return part;
}

std::vector<ExtraFace> extra_faces(const JoinedScan& joined, const Solid& model,
                                   const std::vector<SetUp>& set_ups,
                                   const std::vector<FaceInspection>& faces, const Tolerances& tolerances) {
  const CastScan& cast = joined.cast;
  std::vector<ExtraFace> extra;
  for (const MeasuredPatch& patch : joined.patches) {
    if (patch.model_id != 0 || patch.is_misplaced) continue;
    const RigidTransform& T_model_part = set_ups[patch.set_up].match.T_model_part;
    ExtraFace out{patch.set_up, patch.measured_id,
                  set_ups[patch.set_up].measured.faces()[static_cast<size_t>(patch.measured_id) - 1], false};
    out.face.normal = T_model_part.R * out.face.normal;
    out.face.axis = T_model_part.R * out.face.axis;
    out.face.point_mm = T_model_part * out.face.point_mm;
    out.face.point_on_axis_mm = T_model_part * out.face.point_on_axis_mm;
    out.face.d_mm = out.face.normal.dot(out.face.point_mm);
    size_t off = 0, on_curve = 0;
    for (const uint32_t i : patch.points) {
      if (cast.face[i] < 0) {  // the ray meets no material of the model at all
        ++off;
        continue;
      }
      const Face& face = model.faces()[static_cast<size_t>(cast.face[i])];
      on_curve += face.type != SurfaceType::plane &&
                  is_of_curve(face, faces[static_cast<size_t>(cast.face[i])], cast, i);
      if (tolerances.skip.contains(face.id)) continue;
      off += std::abs(cast.deviation_mm[i]) > offset_limit(tolerances.of(face)) + 3 * cast.sigma_mm[i];
    }
    // A strip of a curved face that came out as a plane is that face, in its place or out of it.
    if (2 * on_curve > patch.points.size()) continue;
    out.out_of_tolerance = tolerances.given && 2 * off > patch.points.size();
    extra.push_back(std::move(out));
  }
  return extra;
}

}  // namespace tetragauge
