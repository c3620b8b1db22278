// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/match.hpp"
#include "host/match/rank_poses.hpp"

namespace tetragauge {

Result<Match> match_face_lists(const FaceList& model, const FaceList& measured, const MatchOptions& options) {
  const Result<MatchInput> input = match_input(model, measured, options);
  if (!input) return input.error();
  const RankedPoses ranked = rank_poses(*input, kSameCost);
  if (ranked.poses.empty()) return no_pose_error(input->model, input->measured, input->gates);
  return conclude_match(*input, ranked);
}

}  // namespace tetragauge
