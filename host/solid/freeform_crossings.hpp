// SPDX-License-Identifier: GPL-3.0-or-later
// Where a line crosses the piece of a free-form surface that a triangle stands for.
#pragma once

#include "host/solid/parametric_surface.hpp"

namespace tetragauge {

// A triangle of the tessellation, counter-clockwise seen from outside, and the surface above it.
struct FreeformPiece {
  std::array<Vec3, 3> corners;
  const ParametricSurface* surface = nullptr;
  std::array<SurfaceParameters, 3> parameters{};  // of the corners
  double height_mm = 0;                           // the surface lies within this of the triangle's plane
};

struct FreeformCrossing {
  double s = 0;  // p + s * direction
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // unit, outward
};

struct FreeformCrossings {
  std::array<FreeformCrossing, 2> crossings;
  size_t count = 0;
};

// Newton's steps on the surface, from where the line crosses the triangle; a flat line, which can cross
// twice, from either end of its way along the piece. Crossings may lie a little beyond the triangle: the
// caller asks whose they are. `direction` is unit.
FreeformCrossings freeform_crossings(const FreeformPiece& piece, const Vec3& p, const Vec3& direction);

// How far the surface gets from the triangle's plane: twice what its middle and those of its edges say.
double freeform_height_mm(const FreeformPiece& piece);

// Whether a line is so flat to a triangle that it may pass its piece of the surface, or cross it twice.
bool is_flat(const Vec3& triangle_normal, const Vec3& direction);

}  // namespace tetragauge
