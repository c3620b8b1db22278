// SPDX-License-Identifier: GPL-3.0-or-later
// Directions in which the part can move without any matched face noticing.
#pragma once

#include <vector>

#include "host/match/match.hpp"

namespace tetragauge {

// `normals`: of the matched model faces, model frame. `point_mm`: on the axis of a free rotation.
std::vector<FreeDirection> free_directions(const std::vector<Vec3>& normals, const Vec3& point_mm);

}  // namespace tetragauge
