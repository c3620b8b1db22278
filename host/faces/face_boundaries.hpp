// SPDX-License-Identifier: GPL-3.0-or-later
// Areas, centroids and neighbours of the faces, with edges put where the planes meet.
#pragma once

#include <set>
#include <vector>

#include "host/faces/trace_boundaries.hpp"

namespace tetragauge {

struct FaceExtent {
  double area_mm2 = 0;              // of what was seen, up to the edges where planes meet
  Vec3 centroid_mm = Vec3::Zero();  // on the plane
  std::set<size_t> neighbours;
  std::vector<uint32_t> triangles;  // wholly on the face, ascending
  std::vector<BoundaryLoop> loops;
};

struct FaceExtents {
  std::vector<FaceExtent> faces;
  double volume_mm3 = 0;  // inside the faces' planes
  size_t strips = 0;      // connected strips of triangles that span an edge: the mesh's false chamfers
};

FaceExtents face_extents(const Reconstruction& reconstruction, const SurfaceGraph& graph,
                         const FittedFaces& fitted);

}  // namespace tetragauge
