// SPDX-License-Identifier: GPL-3.0-or-later
// The calls of a .csg file as one exact shape: OpenCASCADE's primitives and Booleans.
#pragma once

#include <TopoDS_Shape.hxx>
#include <vector>

#include "host/solid/csg_arguments.hpp"

namespace tetragauge {

// Union of `nodes`, with `keep_facets` round bodies as the facets that OpenSCAD makes of them; a null shape
// if there is nothing. Throws CsgFailure, or Standard_Failure from within OpenCASCADE.
TopoDS_Shape build_csg(std::vector<CsgNode> nodes, bool keep_facets = false);

}  // namespace tetragauge
