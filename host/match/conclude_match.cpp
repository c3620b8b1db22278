// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>

#include "host/match/find_misplaced.hpp"
#include "host/match/free_directions.hpp"
#include "host/match/rank_poses.hpp"
#include "host/match/rule_out.hpp"
#include "host/match/turn_text.hpp"

namespace tetragauge {
namespace {

// Whether the motion maps each plane of the model onto one with the same area (and centroid, where known).
bool is_symmetry(const PlaneSet& model, const RigidTransform& motion, bool is_unsigned) {
  const double near_mm = 1e-3 * model.size_mm;
  return std::all_of(model.planes.begin(), model.planes.end(), [&](const MatchPlane& face) {
    const Vec3 normal = motion.R * face.normal;
    const Vec3 point = motion * face.point_mm;
    return std::any_of(model.planes.begin(), model.planes.end(), [&](const MatchPlane& image) {
      const double cosine = image.normal.dot(normal);
      return (is_unsigned ? std::abs(cosine) : cosine) > 1 - 1e-6 &&
             std::abs(image.normal.dot(point) - image.d_mm) < near_mm &&
             std::abs(image.area_mm2 - face.area_mm2) < 0.01 * face.area_mm2 &&
             (!model.has_centroids || (image.point_mm - point).norm() < near_mm);
    });
  });
}

std::string reason(const PlaneSet& model, const RigidTransform& other, const RigidTransform& chosen,
                   bool is_unsigned, double cost_difference) {
  // Free of the noise in the pose, the motion between two poses of a symmetric part is a symmetry; it is
  // tested within a thousandth of the part.
  const RigidTransform motion = other * chosen.inverse();
  if (is_symmetry(model, motion, is_unsigned))
    return "the part is symmetric: " + turn_text(motion.R) + " it is the same";
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), ", misfit differs by %.1f (%.0f would decide)", cost_difference,
                kSameCost);
  return "no measured face tells it apart: " + turn_text(motion.R) + text.data();
}

// Where, along the model's normal through the model face's centroid, the measured plane lies.
double offset_at_model_centroid(const PlaneSet& model, const MatchPlane& face, const PlaneObservation& seen,
                                const RigidTransform& T) {
  const Vec3 normal = T.R * seen.covariance.u.cross(seen.covariance.v);
  if (!model.has_centroids) return plane_residual(seen, T)[0];
  return normal.dot(T * seen.point_mm - face.point_mm) / normal.dot(face.normal);
}

std::vector<FreeDirection> undetermined(const PlaneSet& model, const PlaneSet& measured,
                                        const std::vector<PlanePair>& pairs, const RigidTransform& T) {
  std::vector<Vec3> normals;
  Vec3 point = Vec3::Zero();
  for (const PlanePair& pair : pairs) {
    normals.push_back(model.planes[pair.model].normal);
    point += (T * measured.planes[pair.measured].point_mm) / static_cast<double>(pairs.size());
  }
  return free_directions(normals, point);
}

// The cheapest that the rays do not speak against: features too small or too changed to rule a pose out still
// say which is likelier. Among poses of equal cost (a symmetric part's differ by rounding only) the one
// nearest to no rotation.
size_t choose(const std::vector<RankedPose>& poses) {
  constexpr double kUnlikely = 2;  // standard deviations
  const auto angle = [&](size_t k) { return rotation_angle(poses[k].pose.T_model_part.R); };
  const auto first = std::find_if(poses.begin(), poses.end(),
                                  [](const RankedPose& pose) { return pose.doubt <= kUnlikely; });
  const size_t cheapest = first == poses.end() ? 0 : static_cast<size_t>(first - poses.begin());
  size_t chosen = cheapest;
  for (size_t k = cheapest + 1; k < poses.size(); ++k)
    if (poses[k].doubt <= kUnlikely && poses[k].cost < poses[cheapest].cost + 1 &&
        angle(k) < angle(chosen) - 1e-3)
      chosen = k;
  return chosen;
}

}  // namespace

void write_pairs(const PlaneSet& model, const PlaneSet& measured, const std::vector<PlanePair>& pairs,
                 const std::vector<bool>& used, Match& match) {
  const std::vector<PlaneObservation> seen = observations(model, measured, pairs);
  std::set<int> model_ids(model.other_ids.begin(), model.other_ids.end());
  std::set<int> measured_ids(measured.other_ids.begin(), measured.other_ids.end());
  for (const MatchPlane& face : model.planes) model_ids.insert(face.id);
  for (const MatchPlane& face : measured.planes) measured_ids.insert(face.id);
  for (size_t k = 0; k < pairs.size(); ++k) {
    const MatchPlane& face = model.planes[pairs[k].model];
    FacePair pair;
    pair.model = face.id;
    pair.measured = measured.planes[pairs[k].measured].id;
    pair.offset_mm = offset_at_model_centroid(model, face, seen[k], match.T_model_part);
    const Vec3 residual = plane_residual(seen[k], match.T_model_part);
    pair.angle_rad = std::hypot(residual[1], residual[2]);
    pair.used_in_pose = used[k];
    match.pairs.push_back(pair);
    model_ids.erase(pair.model);
    measured_ids.erase(pair.measured);
  }
  std::sort(match.pairs.begin(), match.pairs.end(), [](const FacePair& a, const FacePair& b) {
    return std::tie(a.model, a.measured) < std::tie(b.model, b.measured);
  });
  match.unmatched_model.assign(model_ids.begin(), model_ids.end());
  match.unmatched_measured.assign(measured_ids.begin(), measured_ids.end());
  match.undetermined = undetermined(model, measured, pairs, match.T_model_part);
}

Match conclude_match(const MatchInput& input, const RankedPoses& ranked) {
  const size_t chosen = choose(ranked.poses);
  const RankedPose& best = ranked.poses[chosen];

  Match match;
  match.T_model_part = best.pose.T_model_part;
  match.covariance = best.pose.covariance;
  match.centroid_mm = input.model.pivot_mm;
  match.rms_mm = best.pose.rms_mm;
  match.max_offset_mm = input.gates.offset_mm;
  match.poses_compared = ranked.compared;

  write_pairs(input.model, input.measured, best.pairs, best.pose.used, match);
  for (size_t k = 0; k < ranked.poses.size(); ++k) {
    if (k == chosen) continue;
    const RigidTransform& other = ranked.poses[k].pose.T_model_part;
    match.equivalents.push_back({other,
                                 reason(input.model, other, match.T_model_part, input.gates.is_unsigned,
                                        std::abs(ranked.poses[k].cost - best.cost)),
                                 undetermined(input.model, input.measured, ranked.poses[k].pairs, other)});
  }
  for (const RankedPose& rival : ranked.rivals)
    match.ruled_out.push_back(ruled_out_by_faces(input, ranked, best, rival));
  match.misplaced = find_misplaced(input, best, match);
  return match;
}

}  // namespace tetragauge
