// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of report.txt; "" where there is nothing to say.
#pragma once

#include <string>

#include "host/report/report.hpp"

namespace tetragauge {

std::string faces_table(const Report& report);      // deviations, what decides, verdict
std::string surface_table(const Report& report);    // roughness; curved faces point by point
std::string relations_table(const Report& report);  // the angles and distances farthest from nominal

}  // namespace tetragauge
