// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/histogram.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {

Histogram histogram(std::span<const float> deviation_mm, double limit_mm, size_t bins) {
  Histogram out;
  if (deviation_mm.empty()) return out;
  std::vector<float> sizes;
  for (const float value : deviation_mm) sizes.push_back(std::abs(value));
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>((sizes.size() - 1) * 99 / 100);
  std::nth_element(sizes.begin(), at, sizes.end());
  // A fifth more than needed, so that the limits do not lie on the frame.
  out.half_width_mm = 1.2 * std::max({limit_mm, static_cast<double>(*at), 1e-6});
  out.counts.assign(bins, 0);
  for (const float value : deviation_mm) {
    const double place = (static_cast<double>(value) / out.half_width_mm + 1) / 2 * static_cast<double>(bins);
    ++out.counts[static_cast<size_t>(std::clamp(place, 0.0, static_cast<double>(bins) - 1))];
  }
  return out;
}

}  // namespace tetragauge
