// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "host/base/result.hpp"

namespace tetragauge {

// Every number of a STEP file is one that geometry can be computed with. OpenCASCADE reads "1.E400" as
// infinity and stumbles over "NaN", and its algorithms then search without end. The error names file and
// line.
Status check_step_numbers(std::string_view content, const std::string& file);

}  // namespace tetragauge
