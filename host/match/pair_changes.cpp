// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/pair_changes.hpp"

#include <algorithm>
#include <iterator>

namespace tetragauge {
namespace {

std::vector<FaceIds> ids(const Match& match) {
  std::vector<FaceIds> out;
  for (const FacePair& pair : match.pairs) out.push_back({pair.model, pair.measured});
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<FaceIds> only_in(const std::vector<FaceIds>& a, const std::vector<FaceIds>& b) {
  std::vector<FaceIds> out;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
  return out;
}

}  // namespace

PairChanges pair_changes(const Match& without_rules, const Match& with_rules) {
  const std::vector<FaceIds> before = ids(without_rules), after = ids(with_rules);
  const RigidTransform motion = with_rules.T_model_part * without_rules.T_model_part.inverse();
  PairChanges changes;
  changes.made = only_in(after, before);
  changes.broken = only_in(before, after);
  changes.shift_mm = motion * without_rules.centroid_mm - without_rules.centroid_mm;
  changes.turn_rad = rotation_angle(motion.R);
  return changes;
}

}  // namespace tetragauge
