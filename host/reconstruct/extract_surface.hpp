// SPDX-License-Identifier: GPL-3.0-or-later
// The boundary between solid and air as triangles with three neighbours each.
#pragma once

#include <vector>

#include "host/reconstruct/average_points.hpp"
#include "host/reconstruct/reconstruct.hpp"
#include "host/reconstruct/tetrahedra.hpp"
#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {

struct Surface {
  std::vector<SurfaceTriangle> triangles;
  std::vector<uint32_t> solid_cell;  // behind each triangle
};

// Where rays claim solid behind a hull facet with air before it, the surface is a sheet without thickness:
// its seen side, and an unseen back that closes it. Triangles are paired across each edge around the solid
// between them, so that parts touching in an edge stay apart and every triangle has three neighbours.
Surface extract_surface(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                        const Visibility& visibility, const Scan& scan, const AveragedPoints& averaged);

// Every neighbour exists, points back, and runs along the shared edge in the opposite direction.
bool is_closed(const std::vector<SurfaceTriangle>& surface);

}  // namespace tetragauge
