// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/measure/volume_noise.hpp"

#include <cmath>

namespace tetragauge {

double volume_sigma_mm3(const std::array<NoisyCorner, 4>& corners) {
  static constexpr size_t kOpposite[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  double variance = 0;
  for (size_t i = 0; i < 4; ++i) {
    // V = A h / 3: a corner changes it by a third of the area of the facet opposite, along that one's normal.
    const Vec3& a = corners[kOpposite[i][0]].at_mm;
    const Vec3 twice_area = (corners[kOpposite[i][1]].at_mm - a).cross(corners[kOpposite[i][2]].at_mm - a);
    const double sigma = corners[i].sigma_mm * twice_area.dot(corners[i].ray) / 6;
    variance += sigma * sigma;
  }
  return std::sqrt(variance);
}

}  // namespace tetragauge
