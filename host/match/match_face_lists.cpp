// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "host/match/match.hpp"
#include "host/match/rank_poses.hpp"

namespace tetragauge {

Result<Match> match_face_lists(const FaceList& model_list, const FaceList& measured_list,
                               const MatchOptions& options) {
  const Result<PlaneSet> model = model_planes(model_list);
  if (!model) return model.error();
  const Result<PlaneSet> measured = measured_planes(measured_list);
  if (!measured) return measured.error();
  const SearchGates gates = search_gates(*model, options);
  const RankedPoses ranked = rank_poses(*model, *measured, gates, kSameCost);
  if (ranked.poses.empty()) return no_pose_error(*model, *measured);
  return conclude_match(*model, *measured, gates, ranked);
}

}  // namespace tetragauge
