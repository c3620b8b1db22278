// SPDX-License-Identifier: GPL-3.0-or-later
// The faces of solids: type, outward equation, area, centroid, neighbours, in canonical order. Patches of one
// surface that share an edge are one face, however the exporter or a Boolean has split it: they are merged in
// the list and left alone in the shape, where merging them has been seen to damage the body
// (ShapeUpgrade_UnifySameDomain on countersinks and fillets).
#pragma once

#include <TopoDS_Face.hxx>
#include <TopoDS_Solid.hxx>
#include <vector>

#include "host/geometry/face.hpp"

namespace tetragauge {

struct ListedFaces {
  FaceList list;
  std::vector<std::vector<TopoDS_Face>> patches;  // of list.faces[i], oriented as in their solid
};

// The order depends on geometry alone, not on the order in the file.
ListedFaces list_faces(const std::vector<TopoDS_Solid>& solids);

}  // namespace tetragauge
