// SPDX-License-Identifier: GPL-3.0-or-later
// The verdict in a sentence.
#pragma once

#include <string>

#include "host/report/report.hpp"

namespace tetragauge {

// "FAIL: face 14 (plane) is 0.400 mm +- 0.004 mm out, limit 0.100 mm"; not wrapped.
std::string verdict_line(const Report& report);

std::string material_sentence(const MaterialFault& fault);

}  // namespace tetragauge
