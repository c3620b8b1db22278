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

// `place`: of each residual on the surface, unrolled into the plane z = 0 or as it is in space (mm).
// `area_mm2`: that the places cover, rather too large. Cells hold enough points that their mean's noise is
// under a twentieth of `tolerance_mm`, and at least 4.
Form form_deviation(std::span<const Vec3> place, std::span<const double> residual_mm, double area_mm2,
                    double tolerance_mm);

// Expected range of n independent standard normal values (Blom, Statistical Estimates and Transformed
// Beta-Variables, 1958).
double expected_range(size_t n);

}  // namespace tetragauge
