// SPDX-License-Identifier: GPL-3.0-or-later
// The boundary of each face of a solid: loops of edges, each with the face on its other side.
#pragma once

#include <optional>
#include <vector>

#include "host/solid/solid.hpp"

namespace tetragauge {

struct EdgeCircle {
  Vec3 centre_mm = Vec3::Zero();
  Vec3 axis = Vec3::Zero();  // unit; the edge runs counter-clockwise about it
  double radius_mm = 0;
};

// From its corner to the corner of the next edge of the loop (to itself, if the loop has no other).
struct LoopEdge {
  Vec3 corner_mm = Vec3::Zero();
  int beyond = 0;  // id of the face on the other side; 0: none, the triangles are open there
  bool is_line = false;
  std::optional<EdgeCircle> circle;  // an arc or all of it
  // Points of a curve between its two corners, which stand for it to the tessellation's chordal deviation;
  // none on a line.
  std::vector<Vec3> points_mm;
};

// Counter-clockwise seen from outside, so that the face lies to the left; a hole's clockwise.
using FaceLoop = std::vector<LoopEdge>;

// Of solid.faces()[i] the loops; of a plane the outer one first. A whole sphere or torus has none.
std::vector<std::vector<FaceLoop>> face_loops(const Solid& solid);

}  // namespace tetragauge
