// SPDX-License-Identifier: GPL-3.0-or-later
// Region growing on the surface: from the flattest neighbourhoods outwards, as far as vertices agree with one
// plane within their own sigma. Gives seeds; the numbers come from the raw points afterwards.
#pragma once

#include <cstdint>
#include <vector>

#include "host/faces/surface_graph.hpp"
#include "host/geometry/vec.hpp"

namespace tetragauge {

struct Plane {
  Vec3 normal = Vec3::Zero();  // unit, out of the material
  double d_mm = 0;             // normal . x = d

  double distance(const Vec3& p) const { return normal.dot(p) - d_mm; }
};

constexpr int32_t kNoRegion = -1;

struct Regions {
  std::vector<Plane> planes;
  std::vector<int32_t> vertex_region;  // per vertex, kNoRegion: none
};

// Regions of fewer than `min_vertices` vertices are not kept.
Regions grow_regions(const Reconstruction& reconstruction, const SurfaceGraph& graph, size_t min_vertices);

}  // namespace tetragauge
