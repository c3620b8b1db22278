// SPDX-License-Identifier: GPL-3.0-or-later
// A ray on the analytic surface of a face, in double, near a hit on its triangles.
#pragma once

#include <optional>

#include "host/geometry/face.hpp"

namespace tetragauge {

// Outward unit normal of the face's surface at `p` (on or near it); nil for a torus or a free-form face.
Vec3 surface_normal(const Face& face, const Vec3& p);

// The crossing of p + s * direction with the surface, as s: of the crossings that go the same way through the
// surface (into the material if `is_entering`) the one nearest to p. nullopt: none, or the surface has no
// closed solution.
std::optional<double> solve_hit(const Face& face, const Vec3& p, const Vec3& direction, bool is_entering);

}  // namespace tetragauge
