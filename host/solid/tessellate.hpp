// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles of faces that know their face and share corners across edges.
#pragma once

#include "host/solid/list_faces.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

// Fills vertices, triangles and triangle_face of `solid`. Returns false if the triangles do not close.
bool tessellate(const ListedFaces& faces, double chordal_deviation_mm, Solid& solid);

}  // namespace tetragauge
