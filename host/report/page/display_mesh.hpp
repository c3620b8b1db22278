// SPDX-License-Identifier: GPL-3.0-or-later
// The model as the page draws it: each face with vertices of its own, dense enough to carry a deviation
// field.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/solid/solid.hpp"

namespace tetragauge {

struct DisplayMesh {
  std::vector<Vec3> vertices;                      // mm, model frame; no vertex is of two faces
  std::vector<uint32_t> vertex_face;               // index into Solid::faces()
  std::vector<std::array<uint16_t, 3>> triangles;  // outward counter-clockwise
  bool is_coarser = false;                         // the tessellation was too fine to be shown as it is
};

// At most `most_triangles` triangles and 65,536 vertices. A finer tessellation is made coarser, corners
// snapped to a grid; a coarser one is refined, edges halved, so that T-junctions never open.
DisplayMesh display_mesh(const Solid& model, size_t most_triangles = 30000);

}  // namespace tetragauge
