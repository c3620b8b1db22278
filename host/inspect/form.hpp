// SPDX-License-Identifier: GPL-3.0-or-later
// Form deviation: peak to valley of the residuals, averaged over cells so that it is form and not noise.
#pragma once

#include <span>
#include <vector>

#include "host/geometry/vec.hpp"

namespace tetragauge {

struct Form {
  double form_mm = 0;  // peak to valley of the cells, the noise's own expected range taken out
  double U_mm = 0;     // k = 2
  double highest_mm = 0, lowest_mm = 0;  // cell means
  size_t cells = 0;
};

// `uv`: place of each residual on the surface (mm). Cells hold enough points that their mean's noise is under
// a twentieth of `tolerance_mm`, and at least 4.
Form form_deviation(std::span<const Eigen::Vector2d> uv, std::span<const double> residual_mm,
                    double tolerance_mm);

// Expected range of n independent standard normal values (Blom, Statistical Estimates and Transformed
// Beta-Variables, 1958).
double expected_range(size_t n);

}  // namespace tetragauge
