// SPDX-License-Identifier: GPL-3.0-or-later
// What the machine says in words of its own, passed on to whoever follows the session.
#pragma once

#include "host/session/run_scan.hpp"

namespace tetragauge {

// The lines that have come since the last call; without options.log they wait.
void show_machine_log(Link& link, const ScanOptions& options);

}  // namespace tetragauge
