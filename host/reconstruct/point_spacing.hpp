// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "host/geometry/vec.hpp"

namespace tetragauge {

// Typical spacing of points on the measured surface, mm: the side of the square that one point has to itself,
// median over up to 2,000 of the points. `sigma_mm` is the typical noise: neighbourhoods are widened until
// they are larger than the noise layer, so that its thickness is not taken for density.
// The order of `points` (distinct) chooses the sample: pass them in canonical order. 0 for fewer than 2.
double point_spacing(std::span<const Vec3> points, double sigma_mm);

}  // namespace tetragauge
