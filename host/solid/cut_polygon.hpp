// SPDX-License-Identifier: GPL-3.0-or-later
// Polygons of mesh files as triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "host/base/result.hpp"
#include "host/solid/triangle_mesh.hpp"

namespace tetragauge {

// Appends the triangles of one polygon, concave ones included, to `mesh`. `place` begins the error for a
// corner that the file does not have, or for more corners than a face has.
Status add_polygon(const std::vector<int64_t>& corners, const std::string& place, TriangleMesh& mesh);

}  // namespace tetragauge
