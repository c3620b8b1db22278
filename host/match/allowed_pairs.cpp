// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/allowed_pairs.hpp"

#include <algorithm>
#include <map>
#include <string>

namespace tetragauge {
namespace {

// The place of a rule as in its file: "pairs.json: fix[2]".
std::string place(const PairRules& rules, bool is_fixed, size_t index) {
  return (rules.file.empty() ? "" : rules.file + ": ") + (is_fixed ? "fix[" : "forbid[") +
         std::to_string(index) + "]";
}

Result<size_t> index_of(const PlaneSet& set, int id, const char* side, const std::string& place) {
  const auto at = std::find_if(set.planes.begin(), set.planes.end(),
                               [&](const MatchPlane& plane) { return plane.id == id; });
  if (at != set.planes.end()) return static_cast<size_t>(at - set.planes.begin());
  const bool other = std::find(set.other_ids.begin(), set.other_ids.end(), id) != set.other_ids.end();
  return bad_input(place + " names " + side + " face " + std::to_string(id) +
                   (other ? ", which is no plane; only planes can be paired by hand"
                          : ", which is not in the list of " + std::string(side) + " faces; check the ids"));
}

}  // namespace

bool AllowedPairs::operator()(size_t model, size_t measured) const {
  if (fixed.contains({model, measured})) return true;
  if (forbidden.contains({model, measured})) return false;
  return std::none_of(fixed.begin(), fixed.end(),
                      [&](const Pair& pair) { return pair.first == model || pair.second == measured; });
}

Result<AllowedPairs> allowed_pairs(const PlaneSet& model, const PlaneSet& measured, const PairRules& rules) {
  AllowedPairs out;
  const auto index = [&](const FaceIds& pair, const std::string& at) -> Result<AllowedPairs::Pair> {
    const Result<size_t> i = index_of(model, pair.model, "model", at);
    if (!i) return i.error();
    const Result<size_t> j = index_of(measured, pair.measured, "measured", at);
    if (!j) return j.error();
    return AllowedPairs::Pair{*i, *j};
  };
  std::map<size_t, std::pair<size_t, size_t>> taken;  // measured plane: its model plane, the rule
  for (size_t k = 0; k < rules.fixed.size(); ++k) {
    const std::string at = place(rules, true, k);
    const Result<AllowedPairs::Pair> pair = index(rules.fixed[k], at);
    if (!pair) return pair.error();
    const auto [first, is_new] = taken.insert({pair->second, {pair->first, k}});
    if (!is_new && first->second.first != pair->first)
      return bad_input(at + " fixes measured face " + std::to_string(rules.fixed[k].measured) +
                       " to a second model face, after " + place(rules, true, first->second.second) +
                       "; keep one of them");
    out.fixed.insert(*pair);
  }
  for (size_t k = 0; k < rules.forbidden.size(); ++k) {
    const std::string at = place(rules, false, k);
    const Result<AllowedPairs::Pair> pair = index(rules.forbidden[k], at);
    if (!pair) return pair.error();
    if (out.fixed.contains(*pair))
      return bad_input(at + " forbids model face " + std::to_string(rules.forbidden[k].model) +
                       " with measured face " + std::to_string(rules.forbidden[k].measured) + ", which " +
                       place(rules, true, taken.at(pair->second).second) + " fixes; keep one of them");
    out.forbidden.insert(*pair);
  }
  return out;
}

}  // namespace tetragauge
