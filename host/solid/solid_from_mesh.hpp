// SPDX-License-Identifier: GPL-3.0-or-later
// A Solid from the triangles of a mesh file.
#pragma once

#include <string>

#include "host/solid/solid.hpp"
#include "host/solid/triangle_mesh.hpp"

namespace tetragauge {

// `mesh` in the file's unit; `place` names the file in errors and warnings. The triangles are the surface:
// planes get their equations, curved regions are freeform faces, and volume and area are those of the
// triangles.
Result<Solid> solid_from_mesh(TriangleMesh mesh, const std::string& place, const ReadSolidOptions& options);

}  // namespace tetragauge
