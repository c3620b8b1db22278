// SPDX-License-Identifier: GPL-3.0-or-later
// The flat objects of a .csg file (polygon, square, circle and Booleans of them) as exact faces in z = 0.
#pragma once

#include <TopoDS_Shape.hxx>
#include <vector>

#include "host/geometry/vec.hpp"
#include "host/solid/csg_arguments.hpp"

namespace tetragauge {

// Union of `nodes`, moved by the x-y part of M; a null shape if there is nothing. Throws CsgFailure.
TopoDS_Shape build_outline(const std::vector<CsgNode>& nodes, const Affine& M = {});

}  // namespace tetragauge
