// SPDX-License-Identifier: GPL-3.0-or-later
// The faces of solids: type, outward equation, area, centroid, neighbours, in canonical order.
#pragma once

#include <TopoDS_Face.hxx>
#include <TopoDS_Solid.hxx>
#include <vector>

#include "host/geometry/face.hpp"

namespace tetragauge {

struct ListedFaces {
  FaceList list;
  std::vector<TopoDS_Face> shapes;  // shapes[i] is list.faces[i], oriented as in its solid
};

// The order depends on geometry alone, not on the order in the file.
ListedFaces list_faces(const std::vector<TopoDS_Solid>& solids);

}  // namespace tetragauge
