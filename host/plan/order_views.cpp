// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/order_views.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {

std::vector<size_t> order_views(const PlanningMachine& machine, const std::vector<StagePlace>& places,
                                const MachineStance& stance) {
  std::vector<MachineStance> at{stance};  // 0: the start, k + 1: place k
  for (const StagePlace& place : places) go_to(machine, place, at.emplace_back());
  const auto leg = [&](size_t from, size_t to) { return travel_time_s(machine, at[from], places[to - 1]); };
  std::vector<size_t> way{0};
  std::vector<size_t> left;
  for (size_t k = 1; k < at.size(); ++k) left.push_back(k);
  while (!left.empty()) {
    const auto nearest = std::min_element(left.begin(), left.end(), [&](size_t a, size_t b) {
      return leg(way.back(), a) < leg(way.back(), b);
    });
    way.push_back(*nearest);
    left.erase(nearest);
  }
  const auto length = [&](const std::vector<size_t>& order) {
    double sum = 0;
    for (size_t k = 1; k < order.size(); ++k) sum += leg(order[k - 1], order[k]);
    return sum;
  };
  double best = length(way);
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t i = 1; i + 1 < way.size(); ++i) {
      for (size_t k = i + 1; k < way.size(); ++k) {
        std::vector<size_t> other = way;
        std::reverse(other.begin() + static_cast<std::ptrdiff_t>(i),
                     other.begin() + static_cast<std::ptrdiff_t>(k) + 1);
        const double time = length(other);
        if (time >= best - 1e-9) continue;
        best = time;
        way = std::move(other);
        changed = true;
      }
    }
  }
  std::vector<size_t> order;
  for (size_t k = 1; k < way.size(); ++k) order.push_back(way[k] - 1);
  return order;
}

}  // namespace tetragauge
