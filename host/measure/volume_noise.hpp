// SPDX-License-Identifier: GPL-3.0-or-later
// How much of a tetrahedron's volume is noise of its corners.
#pragma once

#include <array>

#include "host/geometry/vec.hpp"

namespace tetragauge {

// A measured vertex: it may lie elsewhere along its ray.
struct NoisyCorner {
  Vec3 at_mm = Vec3::Zero();
  Vec3 ray = Vec3::Zero();  // unit; zero: known exactly
  double sigma_mm = 0;      // along the ray
};

// One standard deviation of the volume, to first order.
double volume_sigma_mm3(const std::array<NoisyCorner, 4>& corners);

}  // namespace tetragauge
