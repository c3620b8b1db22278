// SPDX-License-Identifier: GPL-3.0-or-later
// The calls of a .csg file as one exact shape: OpenCASCADE's primitives and Booleans.
#pragma once

#include <TopoDS_Shape.hxx>
#include <vector>

#include "host/solid/csg_arguments.hpp"

namespace tetragauge {

// Union of `nodes`; a null shape if there is nothing. Throws CsgFailure, or Standard_Failure from within
// OpenCASCADE.
TopoDS_Shape build_csg(const std::vector<CsgNode>& nodes);

}  // namespace tetragauge
