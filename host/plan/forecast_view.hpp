// SPDX-License-Identifier: GPL-3.0-or-later
// What a view will measure, ray by ray of its raster, against the model.
#pragma once

#include <vector>

#include "host/plan/head_over_part.hpp"

namespace tetragauge {

// Points each face gets within the largest incidence; by index into Solid::faces(). Error: the window is
// beyond the mirrors' limit.
Result<std::vector<size_t>> forecast_view(const PlanningMachine& machine, const RayCaster& caster,
                                          size_t faces, const RigidTransform& T_part_model,
                                          const PlannedView& view, double max_incidence_rad);

}  // namespace tetragauge
