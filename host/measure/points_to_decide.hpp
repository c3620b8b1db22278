// SPDX-License-Identifier: GPL-3.0-or-later
// Which faces need more points so that undecided ones can be decided, and how many times as many.
#pragma once

#include <map>

#include "host/inspect/inspect.hpp"

namespace tetragauge {

// By model id. An undecided face, and the datum that it is held against where that adds to its U; nothing for
// a face that more points would not decide, because the machine's or the pose's share of U alone is too
// large.
std::map<int, double> points_to_decide(const Inspection& inspection, const Solid& model,
                                       const Tolerances& tolerances, double u_cal_mm);

}  // namespace tetragauge
