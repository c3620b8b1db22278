// SPDX-License-Identifier: GPL-3.0-or-later
// The scan's points coloured by their deviation from the model.
#pragma once

#include <string>

#include "host/inspect/inspect.hpp"

namespace tetragauge {

// Binary PLY in the part frame: x y z, red green blue, scalars `deviation` (mm, + = excess material) and
// `face` (model id, 0: none). Blue is -`scale_mm`, green 0, red +`scale_mm`; points on no face are grey.
std::string deviation_ply(const Scan& scan, const Inspection& inspection, double scale_mm);

}  // namespace tetragauge
