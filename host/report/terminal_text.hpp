// SPDX-License-Identifier: GPL-3.0-or-later
// The report as a terminal shows it.
#pragma once

#include <string>

#include "host/report/report.hpp"

namespace tetragauge {

// report_text(), and as the last line, where a long report leaves off, the verdict again with the path of its
// page. With `colour` verdicts are coloured (ANSI); they stand in words all the same.
std::string terminal_text(const Report& report, const std::string& page_path, bool colour);

// Whether to colour what goes to this file descriptor: it is a terminal that can, and NO_COLOR (no-color.org)
// is unset or empty.
bool wants_colour(int file_descriptor);

}  // namespace tetragauge
