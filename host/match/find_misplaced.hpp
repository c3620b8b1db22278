// SPDX-License-Identifier: GPL-3.0-or-later
// What is left over after the match, matched again among itself: the right shape in the wrong place.
#pragma once

#include "host/match/match.hpp"
#include "host/match/rank_poses.hpp"

namespace tetragauge {

// Left over are the faces without a partner and those out of place. A feature is two or more of them that
// agree on one motion of their own, with at least one distance more than the motion needs: its shape is then
// known to be right. Largest area first.
std::vector<MisplacedFeature> find_misplaced(const MatchInput& input, const RankedPose& chosen,
                                             const Match& match);

}  // namespace tetragauge
