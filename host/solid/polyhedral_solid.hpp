// SPDX-License-Identifier: GPL-3.0-or-later
// A solid with plane faces from its corner points: shared vertices and edges from the start, no sewing.
#pragma once

#include <TopoDS_Solid.hxx>
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

// All faces must run the same way round, seen from outside; which way is found from the volume. Throws
// PolyhedronFailure for an open surface, a face that is not plane, or several pieces.
TopoDS_Solid polyhedral_solid(PolyhedralMesh mesh);

}  // namespace tetragauge
