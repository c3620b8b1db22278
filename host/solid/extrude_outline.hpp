// SPDX-License-Identifier: GPL-3.0-or-later
// linear_extrude and rotate_extrude of a .csg file.
#pragma once

#include <TopoDS_Shape.hxx>

#include "host/solid/csg_arguments.hpp"

namespace tetragauge {

// Both throw CsgFailure; M places the body.
TopoDS_Shape linear_extrude(const CsgNode& node, const Affine& M);
TopoDS_Shape rotate_extrude(const CsgNode& node, const Affine& M);

// The shape moved by a similarity, all its geometry included.
TopoDS_Shape moved(const TopoDS_Shape& shape, const gp_Trsf& T);

}  // namespace tetragauge
