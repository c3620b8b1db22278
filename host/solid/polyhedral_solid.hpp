// SPDX-License-Identifier: GPL-3.0-or-later
// A solid with plane faces from its corner points: shared vertices and edges from the start, no sewing.
#pragma once

#include <TopoDS_Shape.hxx>
#include <stdexcept>
#include <vector>

#include "host/geometry/vec.hpp"

namespace tetragauge {

using CornerLoop = std::vector<size_t>;  // indices of corners, in order around the face

struct PolyhedralFace {
  CornerLoop outer;
  std::vector<CornerLoop> holes;  // run the other way round
};

struct PolyhedralMesh {
  std::vector<Vec3> corners;  // mm
  std::vector<PolyhedralFace> faces;
};

struct PolyhedronFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// One solid, with cavities, or several without. All faces must run the same way round, seen from the air;
// which way is found from the volume. Throws PolyhedronFailure for an open surface or a face that is not
// plane.
TopoDS_Shape polyhedral_solid(PolyhedralMesh mesh);

}  // namespace tetragauge
