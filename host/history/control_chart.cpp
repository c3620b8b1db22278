// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/history/control_chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetragauge {
namespace {

constexpr double kD2 = 1.128;  // expected range of two standard normal values: 2 / sqrt(pi)

struct Rule {
  int number;
  size_t needed, of;
  double sigmas;
};
constexpr std::array kRules{Rule{1, 1, 1, 3}, Rule{2, 2, 3, 2}, Rule{3, 4, 5, 1}, Rule{4, 8, 8, 0}};

// The value at `index` belongs to the pattern itself, else a signal would be told again after it.
bool applies(const Rule& rule, std::span<const double> values, size_t index, double centre, double sigma) {
  for (const double side : {1.0, -1.0}) {
    const auto is_beyond = [&](double value) { return side * (value - centre) > rule.sigmas * sigma; };
    if (!is_beyond(values[index])) continue;
    const size_t first = index + 1 > rule.of ? index + 1 - rule.of : 0;
    const auto window = values.subspan(first, index + 1 - first);
    if (static_cast<size_t>(std::count_if(window.begin(), window.end(), is_beyond)) >= rule.needed)
      return true;
  }
  return false;
}

}  // namespace

ControlChart control_chart(std::span<const double> values) {
  ControlChart chart;
  if (values.empty()) return chart;
  double sum = 0, ranges = 0;
  for (size_t k = 0; k < values.size(); ++k) {
    sum += values[k];
    if (k > 0) ranges += std::abs(values[k] - values[k - 1]);
  }
  chart.centre = sum / static_cast<double>(values.size());
  if (values.size() < 2 || ranges == 0) return chart;
  chart.sigma = ranges / static_cast<double>(values.size() - 1) / kD2;
  for (size_t k = 0; k < values.size(); ++k) {
    for (const Rule& rule : kRules) {
      if (!applies(rule, values, k, chart.centre, chart.sigma)) continue;
      chart.signals.push_back({k, rule.number});
      break;
    }
  }
  return chart;
}

}  // namespace tetragauge
