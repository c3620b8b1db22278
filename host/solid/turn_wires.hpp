// SPDX-License-Identifier: GPL-3.0-or-later
// Plane faces whose boundary runs the wrong way round, as some exporters leave them where a hole touches the
// outline.
#pragma once

#include <TopoDS_Shape.hxx>

namespace tetragauge {

// The shape with the boundaries of plane faces turned where needed: the largest runs counter-clockwise, seen
// along the face's own normal, holes clockwise. Unchanged if there is nothing to turn.
TopoDS_Shape turn_wires(const TopoDS_Shape& shape);

}  // namespace tetragauge
