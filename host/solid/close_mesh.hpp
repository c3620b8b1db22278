// SPDX-License-Identifier: GPL-3.0-or-later
// From the triangles of a file to a closed surface: corners welded, all triangles turned outward.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/result.hpp"
#include "host/solid/triangle_mesh.hpp"

namespace tetragauge {

inline constexpr uint32_t kNoTriangle = 0xFFFFFFFFu;

struct ClosedMesh {
  std::vector<Vec3> vertices;                      // mm; sorted, each of them used
  std::vector<std::array<uint32_t, 3>> triangles;  // outward, counter-clockwise; sorted
  // Across the edge from corner k to the next one; kNoTriangle where more than two triangles meet.
  std::vector<std::array<uint32_t, 3>> neighbour;
  int bodies = 0;
  double rounding_mm = 0;             // how far a coordinate of the file may be off for its digits alone
  std::vector<std::string> warnings;  // what had to be repaired
};

// `mesh` in mm. Errors (open, one-sided, no volume) name `place` and where in the mesh.
Result<ClosedMesh> close_mesh(const TriangleMesh& mesh, const std::string& place);

}  // namespace tetragauge
