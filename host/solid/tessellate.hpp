// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles of faces that know their face and share corners across edges.
#pragma once

#include "host/solid/list_faces.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

struct Tessellation {
  std::vector<Vec3> vertices;  // mm
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> triangle_face;
  std::vector<std::shared_ptr<const ParametricSurface>> surfaces;  // as in Solid
  std::vector<TriangleOnSurface> on_surface;
  bool is_complete = true;  // every face has triangles
  bool is_closed = true;    // every edge is run as often one way as the other
};

Tessellation tessellate(const ListedFaces& faces, double chordal_deviation_mm);

}  // namespace tetragauge
