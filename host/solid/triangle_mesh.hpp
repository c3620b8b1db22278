// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles as a mesh file gives them, before anything is known of faces.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/geometry/vec.hpp"

namespace tetragauge {

struct TriangleMesh {
  std::vector<Vec3> vertices;  // in the file's unit
  std::vector<std::array<uint32_t, 3>>
      triangles;              // counter-clockwise seen from the air, if the file is right
  std::string declared_unit;  // "" if the file says nothing
};

}  // namespace tetragauge
