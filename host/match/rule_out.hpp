// SPDX-License-Identifier: GPL-3.0-or-later
// Why a near-symmetric part lies as it does: which of its features rules out the pose that fits all the rest.
#pragma once

#include "host/match/rank_poses.hpp"
#include "host/match/score_rays.hpp"

namespace tetragauge {

// By the faces that fit in `best` and not in `rival`.
RuledOutPose ruled_out_by_faces(const MatchInput& input, const RankedPoses& ranked, const RankedPose& best,
                                const RankedPose& rival);

// By the rays that agree with `best` and not with `rival`, and the model faces they met there. Both scores
// are of the same rays.
RuledOutPose ruled_out_by_rays(const RigidTransform& T_model_part, const RayScore& rival,
                               const RigidTransform& T_model_part_best, const RayScore& best);

}  // namespace tetragauge
