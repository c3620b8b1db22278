// SPDX-License-Identifier: GPL-3.0-or-later
// What was measured later joins what was measured before, in the same set-up.
#pragma once

#include "host/session/run_scan.hpp"

namespace tetragauge {

// Views of `more` are numbered on from `first_view`.
void append_scan(Scan& scan, const Scan& more, uint32_t first_view);
void add_counts(ScanCounts& counts, const ScanCounts& more);

}  // namespace tetragauge
