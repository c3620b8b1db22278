// SPDX-License-Identifier: GPL-3.0-or-later
// A person's rules, as indices into the two plane sets.
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "host/match/match.hpp"
#include "host/match/plane_set.hpp"

namespace tetragauge {

struct AllowedPairs {
  using Pair = std::pair<size_t, size_t>;  // index of the model plane, of the measured plane
  std::set<Pair> fixed, forbidden;

  // A face of a fixed pair is for its partner alone.
  bool operator()(size_t model, size_t measured) const;
  bool is_fixed(size_t model, size_t measured) const { return fixed.contains({model, measured}); }
};

// Errors (bad input): a rule names a face that is none or no plane, fixes a measured face twice, or fixes and
// forbids one pair. Several measured faces may be fixed to one model face: its fragments.
Result<AllowedPairs> allowed_pairs(const PlaneSet& model, const PlaneSet& measured, const PairRules& rules);

}  // namespace tetragauge
