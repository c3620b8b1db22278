// SPDX-License-Identifier: GPL-3.0-or-later
// report.html: one file that needs no network. Verdict, tables and facts are plain HTML; a script adds the
// part in 3-D, pictures of the views and the sphere of normals.
#pragma once

#include <string>

#include "host/report/report.hpp"

namespace tetragauge {

// Equal runs give equal pages: no times are in it.
std::string report_page(const Report& report);

}  // namespace tetragauge
