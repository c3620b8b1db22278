// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <numbers>

#include "host/simulate/simulate.hpp"

namespace tetragauge {

std::vector<Vec3> view_directions(int views) {
  std::vector<Vec3> directions;
  if (views == 8 || views == 14) {
    for (int i = 0; i < 8; ++i) {
      directions.push_back(Vec3(i & 1 ? -1 : 1, i & 2 ? -1 : 1, i & 4 ? -1 : 1).normalized());
    }
  }
  if (views == 6 || views == 14) {
    for (int axis = 0; axis < 3; ++axis) {
      directions.push_back(Vec3::Unit(axis));
      directions.push_back(-Vec3::Unit(axis));
    }
  }
  if (!directions.empty()) return directions;
  // The golden-angle spiral: equal steps in height are equal areas (Archimedes).
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < views; ++i) {
    const double z = 1 - (2.0 * i + 1) / views;
    const double across = std::sqrt(1 - z * z);
    directions.emplace_back(across * std::cos(golden_angle * i), across * std::sin(golden_angle * i), z);
  }
  return directions;
}

}  // namespace tetragauge
