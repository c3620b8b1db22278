// SPDX-License-Identifier: GPL-3.0-or-later
// Points evenly over a model's surface, each with its outward normal.
#pragma once

#include <cstddef>
#include <vector>

#include "host/geometry/vec.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

struct SurfaceSample {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // unit, outward
  int face = -1;               // index of the model's
};

// Equal areas give equal numbers of samples; any first part of the list is spread over the whole surface.
std::vector<SurfaceSample> surface_samples(const Solid& model, size_t count);

}  // namespace tetragauge
