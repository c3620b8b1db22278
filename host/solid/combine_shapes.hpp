// SPDX-License-Identifier: GPL-3.0-or-later
// Booleans of a .csg file on exact shapes, solids and flat faces alike.
#pragma once

#include <TopoDS_Shape.hxx>
#include <vector>

#include "host/solid/csg_arguments.hpp"

namespace tetragauge {

// A null shape is the empty set. `node` is named in the CsgFailure thrown when OpenCASCADE gives up.
TopoDS_Shape unite(const CsgNode& node, const std::vector<TopoDS_Shape>& shapes);
TopoDS_Shape subtract(const CsgNode& node,
                      const std::vector<TopoDS_Shape>& shapes);  // the rest from the first
TopoDS_Shape intersect(const CsgNode& node, const std::vector<TopoDS_Shape>& shapes);

}  // namespace tetragauge
