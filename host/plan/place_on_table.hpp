// SPDX-License-Identifier: GPL-3.0-or-later
// How a model stands on the table when nobody has measured it.
#pragma once

#include "host/geometry/rigid_transform.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

// T_part_model of a part turned by R of `place`, stood with the middle of its box on the rotary axis and its
// lowest point on the table's top, then shifted by t of `place` (docs/conventions.md).
RigidTransform place_on_table(const Solid& model, const RigidTransform& place);

}  // namespace tetragauge
