// SPDX-License-Identifier: GPL-3.0-or-later
// Poses from the lists, then what the rays know and the lists do not: where the outlines of the faces are,
// and where there was air. The fit to the measured planes is a fit to their raw points: a plane's offset,
// tilts and covariance are sufficient statistics of the points it was fitted to.
#include <algorithm>
#include <cmath>

#include "host/match/match.hpp"
#include "host/match/rank_poses.hpp"
#include "host/match/score_rays.hpp"

namespace tetragauge {
namespace {

// The lists alone may prefer a wrong pose of a near-symmetric part by a small face or two.
constexpr double kLetRaysDecide = 3 * kFaceCost;

// Keeps the poses that the rays contradict no more than the best; points on no face of the part (fixture,
// table) contradict all poses alike.
void keep_what_rays_allow(std::vector<RankedPose>& poses, const RayCaster& caster, const Scan& scan,
                          double tolerance_mm) {
  // Some 2,000 rays show a difference of one part in a hundred; with many poses to compare, fewer.
  const size_t samples = std::clamp<size_t>(20000 / poses.size(), 300, 2000);
  std::vector<RayScore> scores;
  for (const RankedPose& pose : poses)
    scores.push_back(score_rays(caster, scan, pose.pose.T_model_part, samples, tolerance_mm));
  size_t least = scores[0].against();
  for (const RayScore& score : scores) least = std::min(least, score.against());
  // Counts of rays near the tolerance scatter like a binomial; beyond four sigma it is no chance.
  const double limit = static_cast<double>(least) + 4 * std::sqrt(static_cast<double>(least) + 4);
  std::vector<RankedPose> kept;
  for (size_t k = 0; k < poses.size(); ++k)
    if (static_cast<double>(scores[k].against()) <= limit) kept.push_back(std::move(poses[k]));
  poses = std::move(kept);
}

}  // namespace

Result<Match> match_scan(const Solid& solid, const RayCaster& caster, const Scan& scan,
                         const MeasuredFaces& faces, const MatchOptions& options) {
  Result<PlaneSet> model = model_planes(solid.list);
  if (!model) return model.error();
  model->pivot_mm = solid.centroid_mm;
  model->size_mm = (solid.box_max_mm - solid.box_min_mm).norm();
  const Result<PlaneSet> measured = measured_planes(faces.list);
  if (!measured) return measured.error();
  const SearchGates gates = search_gates(*model, options);
  RankedPoses ranked = rank_poses(*model, *measured, gates, kLetRaysDecide);
  if (ranked.poses.empty()) return no_pose_error(*model, *measured);
  if (ranked.poses.size() > 1) {
    keep_what_rays_allow(ranked.poses, caster, scan, 0.3 * gates.offset_mm);
    const double limit = ranked.poses[0].cost + kSameCost;
    std::erase_if(ranked.poses, [&](const RankedPose& pose) { return pose.cost >= limit; });
  }
  return conclude_match(*model, *measured, gates, ranked);
}

}  // namespace tetragauge
