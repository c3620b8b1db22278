// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/allowed_pairs.hpp"

#include <algorithm>
#include <string>

namespace tetragauge {
namespace {

Result<size_t> index_of(const PlaneSet& set, int id, const char* side) {
  const auto at = std::find_if(set.planes.begin(), set.planes.end(),
                               [&](const MatchPlane& plane) { return plane.id == id; });
  if (at != set.planes.end()) return static_cast<size_t>(at - set.planes.begin());
  const bool other = std::find(set.other_ids.begin(), set.other_ids.end(), id) != set.other_ids.end();
  return bad_input(std::string("the pairs name ") + side + " face " + std::to_string(id) +
                   (other ? ", which is no plane; only planes can be paired by hand"
                          : ", which is not in the list; check the ids"));
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
  const auto collect = [&](const std::vector<FaceIds>& ids, std::set<AllowedPairs::Pair>& into) -> Status {
    for (const FaceIds& pair : ids) {
      const Result<size_t> i = index_of(model, pair.model, "model");
      if (!i) return i.error();
      const Result<size_t> j = index_of(measured, pair.measured, "measured");
      if (!j) return j.error();
      into.insert({*i, *j});
    }
    return Done{};
  };
  if (Status status = collect(rules.fixed, out.fixed); !status) return status.error();
  if (Status status = collect(rules.forbidden, out.forbidden); !status) return status.error();
  std::set<size_t> taken;
  for (const AllowedPairs::Pair& pair : out.fixed) {
    const std::string name = "measured face " + std::to_string(measured.planes[pair.second].id);
    if (!taken.insert(pair.second).second)
      return bad_input("the pairs fix " + name + " to two model faces; keep one of them");
    if (out.forbidden.contains(pair))
      return bad_input("the pairs fix " + name + " to model face " +
                       std::to_string(model.planes[pair.first].id) + " and forbid it too; keep one of them");
  }
  return out;
}

}  // namespace tetragauge
