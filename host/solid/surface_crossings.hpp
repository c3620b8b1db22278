// SPDX-License-Identifier: GPL-3.0-or-later
// Where a line crosses the analytic surface of a face, in double.
#pragma once

#include <array>

#include "host/geometry/face.hpp"

namespace tetragauge {

// Whether the surface is one that lines are solved on: plane, cylinder, cone, sphere, or a torus with a hole.
bool has_crossings(const Face& face);

// Outward unit normal of the face's surface at `p` (on or near it); nil for a face without crossings.
Vec3 surface_normal(const Face& face, const Vec3& p);

// The crossings p + s * direction, ascending, in and out by turns.
struct SurfaceCrossings {
  std::array<double, 4> s{};
  std::array<bool, 4> is_entering{};
  size_t count = 0;
};
SurfaceCrossings surface_crossings(const Face& face, const Vec3& p, const Vec3& direction);

}  // namespace tetragauge
