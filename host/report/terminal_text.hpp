// SPDX-License-Identifier: GPL-3.0-or-later
// The report as a terminal shows it.
#pragma once

#include <string>

#include "host/report/report.hpp"

namespace tetragauge {

// summary_text(), where the rest of report.txt stands, and as the last line the verdict again with the path
// of the page. With `colour` verdicts are coloured (ANSI); they stand in words all the same.
std::string terminal_text(const Report& report, const std::string& page_path, bool colour);

// Whether to colour what goes to this file descriptor: it is a terminal that can, and NO_COLOR (no-color.org)
// is unset or empty.
bool wants_colour(int file_descriptor);

}  // namespace tetragauge
