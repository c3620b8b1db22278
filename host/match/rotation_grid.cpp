// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/rotation_grid.hpp"

#include <cmath>
#include <numbers>

namespace tetragauge {

std::vector<Mat3> rotation_grid(size_t count) {
  constexpr double kPhi = std::numbers::sqrt2,
                   kPsi = 1.533751168755204288118041;  // the paper's, psi^4 = psi + 4
  std::vector<Mat3> rotations;
  const auto n = static_cast<double>(count);
  for (size_t i = 0; i < count; ++i) {
    const double s = static_cast<double>(i) + 0.5;
    const double r = std::sqrt(s / n), R = std::sqrt(1 - s / n);
    const double alpha = 2 * std::numbers::pi * s / kPhi, beta = 2 * std::numbers::pi * s / kPsi;
    rotations.push_back(
        Eigen::Quaterniond(R * std::cos(beta), r * std::sin(alpha), r * std::cos(alpha), R * std::sin(beta))
            .normalized()
            .toRotationMatrix());
  }
  return rotations;
}

}  // namespace tetragauge
