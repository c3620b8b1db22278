// SPDX-License-Identifier: GPL-3.0-or-later
// All measured points of a report, in the order of Inspection::point_face.
#pragma once

#include <vector>

#include "host/report/report.hpp"

namespace tetragauge {

std::vector<Vec3> points_in_model(const Report& report);  // mm, model frame, each scan by its own pose

}  // namespace tetragauge
