// SPDX-License-Identifier: GPL-3.0-or-later
// The facets of a mesh put together to the faces that their author had in mind: planes, and curved regions.
#pragma once

#include <cstdint>
#include <vector>

#include "host/solid/close_mesh.hpp"

namespace tetragauge {

struct FacetGroup {
  bool is_plane = true;
  Vec3 normal = Vec3::Zero();       // plane: unit, outward
  double d_mm = 0;                  // plane: normal . x = d
  std::vector<uint32_t> triangles;  // ascending
};

struct FacetGroups {
  std::vector<FacetGroup> groups;
  double off_plane_mm = 0;  // corners of a plane lie this near to it
};

// Triangles of one plane that hang together are one group. With `curved`, four facets or more of like width
// that each turn by less than 30 degrees from the last are what an exporter has made of one curved face, and
// one group too.
FacetGroups group_facets(const ClosedMesh& mesh, bool curved = true);

}  // namespace tetragauge
