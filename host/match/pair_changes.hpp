// SPDX-License-Identifier: GPL-3.0-or-later
// What a person's rules did to a match.
#pragma once

#include <vector>

#include "host/match/match.hpp"

namespace tetragauge {

struct PairChanges {
  std::vector<FaceIds> made, broken;  // ascending
  Vec3 shift_mm = Vec3::Zero();       // of the part's centroid by the new pose, model frame
  double turn_rad = 0;
};

PairChanges pair_changes(const Match& without_rules, const Match& with_rules);

}  // namespace tetragauge
