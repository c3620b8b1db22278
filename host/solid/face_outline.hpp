// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of one model face: samples over its area, its corners, points along its boundary.
#pragma once

#include <vector>

#include "host/solid/solid.hpp"

namespace tetragauge {

struct FaceOutline {
  std::vector<std::array<Vec3, 3>> triangles;
  std::vector<Vec3> corners;                  // all vertices of the triangles
  std::vector<std::array<Vec3, 2>> boundary;  // edges that only one of its triangles has
};

// One per model face, in its order.
std::vector<FaceOutline> face_outlines(const Solid& model);

// About `count` points, evenly over the area.
std::vector<Vec3> samples_over(const FaceOutline& outline, size_t count);

// Points along the boundary, at most `step_mm` apart.
std::vector<Vec3> samples_along(const FaceOutline& outline, double step_mm);

}  // namespace tetragauge
