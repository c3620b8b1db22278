// SPDX-License-Identifier: GPL-3.0-or-later
// The scan's points coloured by their deviation from the model.
#pragma once

#include <string>

#include "host/report/report.hpp"

namespace tetragauge {

// Binary PLY: x y z, red green blue, scalars `deviation` (mm, + = excess material) and `face` (model id, 0:
// none). Blue is -`scale_mm`, green 0, red +`scale_mm`; points on no face are grey. In the part frame of the
// (first) scan; further scans are brought there by their poses.
std::string deviation_ply(const Report& report, double scale_mm);

}  // namespace tetragauge
