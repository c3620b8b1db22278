// SPDX-License-Identifier: GPL-3.0-or-later
// Where a line crosses the analytic surface of a face, in double.
#pragma once

#include <array>

#include "host/geometry/face.hpp"

namespace tetragauge {

// Whether the surface is one that lines are solved on: plane, cylinder, cone or sphere.
bool has_crossings(SurfaceType type);

// Outward unit normal of the face's surface at `p` (on or near it); nil for a torus or a free-form face.
Vec3 surface_normal(const Face& face, const Vec3& p);

// The crossings p + s * direction, at most one into the material and one out of it.
struct SurfaceCrossings {
  std::array<double, 2> s{};
  std::array<bool, 2> is_entering{};
  size_t count = 0;
};
SurfaceCrossings surface_crossings(const Face& face, const Vec3& p, const Vec3& direction);

}  // namespace tetragauge
