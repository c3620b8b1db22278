// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "host/match/match.hpp"

namespace tetragauge {

// Whether points on curved faces of the model hold a direction that its planes leave free: the rim and the
// hub of a flange hold it across its axis, however many of the points lie on its planes. `T_model_part`: a
// pose by the model's whole surface.
bool curves_hold(const std::vector<FreeDirection>& free, const Solid& model, const RayCaster& caster,
                 const Scan& scan, const RigidTransform& T_model_part, double tolerance_mm);

}  // namespace tetragauge
