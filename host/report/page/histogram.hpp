// SPDX-License-Identifier: GPL-3.0-or-later
// How the points of one face lie about the model's surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tetragauge {

struct Histogram {
  double half_width_mm = 0;      // the bins go from -half_width_mm to +half_width_mm
  std::vector<uint32_t> counts;  // the outermost hold what lies beyond as well; empty without values
};

// Wide enough for `limit_mm` (0: none) and for 99 of 100 values.
Histogram histogram(std::span<const float> deviation_mm, double limit_mm, size_t bins = 48);

}  // namespace tetragauge
