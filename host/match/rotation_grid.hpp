// SPDX-License-Identifier: GPL-3.0-or-later
// Rotations spread evenly over all there are.
#pragma once

#include <cstddef>
#include <vector>

#include "host/geometry/vec.hpp"

namespace tetragauge {

// Super-Fibonacci spirals (Alexa, CVPR 2022). 4,400 leave no rotation farther than some 15 degrees from one.
std::vector<Mat3> rotation_grid(size_t count);

}  // namespace tetragauge
