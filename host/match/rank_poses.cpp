// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/rank_poses.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/match/free_directions.hpp"

namespace tetragauge {
namespace {

// Poses that explain less than this share of what the best one does cannot win on the details. What noise
// takes from the explained weight of a good pose scatters with the number of faces.
double share_to_keep(size_t faces) {
  return 1 - 0.25 * std::min(1.0, std::sqrt(10.0 / static_cast<double>(faces)));
}
// A pose that is sure to cost so much more than another (four faces) is not looked at further, not even as
// the rival of a near-symmetric part.
constexpr double kHopeless = 4 * kFaceCost;
// A pose that explains so much of what the best one does is worth telling why it is not the one.
constexpr double kRival = 0.75;

// A face alone along its direction fits there whatever it is; one that is also tilted beyond belief (an extra
// face that happens to lie within the gates) would pin the part where nothing holds it. A plane of any
// direction lies within the gate of a given normal with probability (1 - cos gate) / 2, and a good face's two
// tilts are that seldom beyond chi-square = -2 ln of it. Two such faces on two planes of one direction agree
// where the part lies, which extra ones hardly do: they stay. True if any went.
bool drop_unsupported(const PlaneSet& model, const PlaneSet& measured, const SearchGates& gates,
                      RankedPose& pose) {
  const double most_tilt = -2 * std::log(0.5 * (1 - std::cos(gates.angle_rad)));
  std::vector<Vec3> believed;
  std::vector<bool> doubtful;
  for (const PlanePair& pair : pose.pairs) {
    const PlaneObservation seen =
        observe(model.planes[pair.model], measured.planes[pair.measured], pair.flipped);
    const Vec3 r = plane_residual(seen, pose.pose.T_model_part);
    const double added = pose.pose.scatter_rad * pose.pose.scatter_rad;
    const double tilt = r[1] * r[1] / (seen.covariance.matrix(1, 1) + added) +
                        r[2] * r[2] / (seen.covariance.matrix(2, 2) + added);
    doubtful.push_back(tilt > most_tilt);
    if (!doubtful.back()) believed.push_back(model.planes[pair.model].normal);
  }
  if (believed.empty()) return false;
  const std::vector<FreeDirection> free = free_directions(believed, Vec3::Zero());
  std::vector<PlanePair> kept;
  for (size_t k = 0; k < pose.pairs.size(); ++k) {
    const Vec3& normal = model.planes[pose.pairs[k].model].normal;
    const bool alone = std::any_of(free.begin(), free.end(), [&](const FreeDirection& direction) {
      return direction.kind == FreeDirection::Kind::translation &&
             std::abs(direction.axis.dot(normal)) > 0.01;
    });
    const bool agrees = std::any_of(pose.pairs.begin(), pose.pairs.end(), [&](const PlanePair& other) {
      const MatchPlane& plane = model.planes[other.model];
      return plane.group != model.planes[pose.pairs[k].model].group &&
             std::abs(plane.normal.dot(normal)) > 1 - 1e-8;
    });
    const bool fixed = gates.allowed.is_fixed(pose.pairs[k].model, pose.pairs[k].measured);
    if (fixed || agrees || !(doubtful[k] && alone)) kept.push_back(pose.pairs[k]);
  }
  const bool dropped = kept.size() < pose.pairs.size();
  pose.pairs = std::move(kept);
  return dropped;
}

RankedPose refined(const MatchInput& input, const RigidTransform& start) {
  const PlaneSet &model = input.model, &measured = input.measured;
  const SearchGates& gates = input.gates;
  RankedPose out;
  out.pose.T_model_part = start;
  FragmentLimits fragment;  // none at first: how far pieces may differ is known from the faces' scatter
  for (int pass = 0; pass < 2; ++pass) {
    out.pairs = pair_planes(model, measured, out.pose.T_model_part, gates, fragment);
    if (out.pairs.empty()) return out;
    out.pose = refine_pose(observations(model, measured, out.pairs), out.pose.T_model_part, model.pivot_mm,
                           model.size_mm, input.prior);
    fragment.offset_mm = std::min(gates.offset_mm, std::max(4 * out.pose.scatter_mm, 0.05 * gates.offset_mm));
    fragment.angle_rad =
        std::min(gates.angle_rad, std::max(4 * out.pose.scatter_rad, 0.05 * gates.angle_rad));
  }
  if (drop_unsupported(model, measured, gates, out))
    out.pose = refine_pose(observations(model, measured, out.pairs), out.pose.T_model_part, model.pivot_mm,
                           model.size_mm, input.prior);
  return out;
}

// As the search counts it, but for the pairs that are left after a look at the centroids.
double explained(const PlaneSet& model, const PlaneSet& measured, const RankedPose& pose,
                 const SearchGates& gates) {
  double total = 0;
  for (const PlanePair& pair : pose.pairs) {
    const MatchPlane& seen = measured.planes[pair.measured];
    const Vec3 r =
        plane_residual(observe(model.planes[pair.model], seen, pair.flipped), pose.pose.T_model_part);
    const double offset = r[0] / gates.offset_mm, turn = std::hypot(r[1], r[2]) / gates.angle_rad;
    total += seen.weight * std::max(0.0, (1 - offset * offset) * (1 - turn * turn));
  }
  return total;
}

double cost(const MatchInput& input, const RankedPose& pose, double scatter_mm, double scatter_rad) {
  const std::vector<double> costs =
      face_costs(input.model, input.measured, pose.pose.T_model_part, pose.pairs, scatter_mm, scatter_rad);
  return std::accumulate(costs.begin(), costs.end(), 0.0);
}

// What a pose will cost at least, wherever the refinement takes it: faces that are not even near any model
// face.
double least_cost(const MatchInput& input, const RigidTransform& T) {
  SearchGates wide = input.gates;
  wide.offset_mm *= 2;
  wide.angle_rad *= 2;
  const std::vector<PlanePair> pairs =
      pair_planes(input.model, input.measured, T, wide, {wide.offset_mm, wide.angle_rad});
  std::vector<double> costs = face_costs(input.model, input.measured, T, {}, 0, 0);
  for (const PlanePair& pair : pairs) costs[pair.measured] = 0;
  return std::accumulate(costs.begin(), costs.end(), 0.0);
}

bool same_pairs(const std::vector<PlanePair>& a, const std::vector<PlanePair>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PlanePair& x, const PlanePair& y) {
    return x.model == y.model && x.measured == y.measured && x.flipped == y.flipped;
  });
}

bool same_pose(const RankedPose& a, const RankedPose& b, const Vec3& part_centroid,
               const SearchGates& gates) {
  if (same_pairs(a.pairs, b.pairs)) return true;
  const RigidTransform &A = a.pose.T_model_part, &B = b.pose.T_model_part;
  return rotation_angle(A.R * B.R.transpose()) < 0.3 * gates.angle_rad &&
         (A * part_centroid - B * part_centroid).norm() < 0.3 * gates.offset_mm;
}

}  // namespace

Result<PlaneSet> model_planes(const FaceList& model) {
  PlaneSet planes = plane_set(model, kModelDirection_rad);
  if (planes.planes.empty())
    return bad_input("the model has no planar face to match (" + std::to_string(model.faces.size()) +
                     " faces in all); give a model with planes");
  return planes;
}

Result<PlaneSet> measured_planes(const FaceList& measured) {
  PlaneSet planes = plane_set(measured, kDefaultMaxAngle_rad / 4);
  if (planes.planes.empty())
    return undecided_error("no planar face was measured (" + std::to_string(measured.faces.size()) +
                           " faces in all); scan more of the part or at a finer pitch");
  return planes;
}

Result<MatchInput> match_input(const FaceList& model_list, const FaceList& measured_list,
                               const MatchOptions& options) {
  Result<PlaneSet> model = model_planes(model_list);
  if (!model) return model.error();
  Result<PlaneSet> measured = measured_planes(measured_list);
  if (!measured) return measured.error();
  Result<AllowedPairs> allowed = allowed_pairs(*model, *measured, options.rules);
  if (!allowed) return allowed.error();
  SearchGates gates;
  gates.allowed = std::move(*allowed);
  gates.is_unsigned = options.is_unsigned;
  gates.offset_mm = options.max_offset_mm > 0 ? options.max_offset_mm : kDefaultMaxOffset * model->size_mm;
  gates.angle_rad = options.max_angle_rad > 0 ? options.max_angle_rad : kDefaultMaxAngle_rad;
  // A list without uncertainties of its own: the gates are where a face is no longer believed, six standard
  // deviations.
  ScatterPrior prior;
  const auto known = [](const MatchPlane& plane) { return plane.has_covariance; };
  if (!std::any_of(measured->planes.begin(), measured->planes.end(), known))
    prior = {gates.offset_mm / 6, gates.angle_rad / 6};
  return MatchInput{model_list,           measured_list, options, std::move(*model),
                    std::move(*measured), gates,         prior};
}

Error no_pose_error(const PlaneSet& model, const PlaneSet& measured, const SearchGates& gates) {
  if (!gates.allowed.fixed.empty())
    return undecided_error("no pose has all the fixed pairs within " +
                           std::to_string(std::lround(kFixedGates * gates.offset_mm)) +
                           " mm; check which faces the pairs name");
  return undecided_error("no pose explains the measured faces (" + std::to_string(measured.planes.size()) +
                         " planes measured, " + std::to_string(model.planes.size()) +
                         " in the model); is this the part's model, and are both in the same unit?");
}

RankedPoses rank_poses(const MatchInput& input, double within, size_t most_candidates) {
  const PlaneSet &model = input.model, &measured = input.measured;
  const SearchGates& gates = input.gates;
  RankedPoses out;
  std::vector<PoseCandidate> candidates =
      search_poses(model, measured, gates, share_to_keep(measured.planes.size()));
  out.compared = candidates.size();
  if (candidates.size() > most_candidates) candidates.resize(most_candidates);
  double cheapest = 1e300;  // so far, each with its own scatter
  for (const PoseCandidate& candidate : candidates) {
    if (least_cost(input, candidate.T_model_part) > cheapest + within + kHopeless) continue;
    RankedPose pose = refined(input, candidate.T_model_part);
    if (pose.pairs.empty()) continue;
    cheapest = std::min(cheapest, cost(input, pose, pose.pose.scatter_mm, pose.pose.scatter_rad));
    out.poses.push_back(std::move(pose));
  }
  if (out.poses.empty()) return out;

  // All poses are judged with one scatter: that of the pose that explains most, then that of the cheapest.
  size_t best = 0;
  for (size_t k = 1; k < out.poses.size(); ++k)
    if (explained(model, measured, out.poses[k], gates) > explained(model, measured, out.poses[best], gates))
      best = k;
  for (int pass = 0; pass < 2; ++pass) {
    out.scatter_mm = out.poses[best].pose.scatter_mm;
    out.scatter_rad = out.poses[best].pose.scatter_rad;
    for (RankedPose& pose : out.poses) {
      const std::vector<double> costs =
          face_costs(model, measured, pose.pose.T_model_part, pose.pairs, out.scatter_mm, out.scatter_rad);
      pose.cost = std::accumulate(costs.begin(), costs.end(), 0.0);
    }
    best = 0;
    for (size_t k = 1; k < out.poses.size(); ++k)
      if (out.poses[k].cost < out.poses[best].cost) best = k;
  }
  const double limit = out.poses[best].cost + within;
  std::stable_sort(out.poses.begin(), out.poses.end(),
                   [](const RankedPose& a, const RankedPose& b) { return a.cost < b.cost; });
  const double almost = kRival * explained(model, measured, out.poses[0], gates);
  std::vector<RankedPose> kept;
  for (RankedPose& pose : out.poses) {
    const auto same = [&](const RankedPose& other) {
      return same_pose(pose, other, measured.centroid_mm, gates);
    };
    // Of rivals that only shift the part one is enough.
    const auto turned_alike = [&](const RankedPose& other) {
      return rotation_angle(pose.pose.T_model_part.R * other.pose.T_model_part.R.transpose()) <
             gates.angle_rad;
    };
    if (std::any_of(kept.begin(), kept.end(), same)) continue;
    if (pose.cost < limit) {
      kept.push_back(std::move(pose));
    } else if (out.rivals.size() < kMostRuledOut && explained(model, measured, pose, gates) > almost &&
               std::none_of(kept.begin(), kept.end(), turned_alike) &&
               std::none_of(out.rivals.begin(), out.rivals.end(), turned_alike)) {
      out.rivals.push_back(std::move(pose));
    }
  }
  out.poses = std::move(kept);
  return out;
}

}  // namespace tetragauge
