// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/history/capability.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

namespace tetragauge {
namespace {

Interval cp_interval(double cp, size_t n, double confidence) {
  const double freedom = static_cast<double>(n - 1);
  const boost::math::chi_squared chi_square(freedom);
  const double tail = 0.5 * (1 - confidence);
  return {cp * std::sqrt(boost::math::quantile(chi_square, tail) / freedom),
          cp * std::sqrt(boost::math::quantile(boost::math::complement(chi_square, tail)) / freedom)};
}

Interval cpk_interval(double cpk, size_t n, double confidence) {
  const double z = boost::math::quantile(boost::math::normal(), 0.5 * (1 + confidence));
  const double count = static_cast<double>(n);
  const double half = z * std::sqrt(1 / (9 * count) + cpk * cpk / (2 * (count - 1)));
  return {cpk - half, cpk + half};
}

}  // namespace

Capability capability_of(std::span<const double> values, std::optional<double> lower,
                         std::optional<double> upper, double confidence) {
  Capability result;
  result.n = values.size();
  if (values.empty()) return result;
  const double count = static_cast<double>(result.n);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  result.min = *least;
  result.max = *most;
  double sum = 0;
  for (const double value : values) sum += value;
  result.mean = std::clamp(sum / count, result.min, result.max);
  // Equal values must give exactly 0, whatever rounding does to the mean.
  if (result.n < 2 || result.min == result.max) return result;
  double squares = 0;
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  result.s = std::sqrt(squares / (count - 1));
  if (result.n < kFewestForCapability || !(result.s > 0)) return result;

  if (lower && upper) {
    result.cp = (*upper - *lower) / (6 * result.s);
    result.cp_interval = cp_interval(*result.cp, result.n, confidence);
  }
  if (lower) result.cpk = (result.mean - *lower) / (3 * result.s);
  if (upper) {
    const double above = (*upper - result.mean) / (3 * result.s);
    result.cpk = result.cpk ? std::min(*result.cpk, above) : above;
  }
  if (result.cpk) result.cpk_interval = cpk_interval(*result.cpk, result.n, confidence);
  return result;
}

}  // namespace tetragauge
