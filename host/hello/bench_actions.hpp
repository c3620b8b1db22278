// SPDX-License-Identifier: GPL-3.0-or-later
// What somebody who builds a machine has it do, one thing at a time, with an instrument in hand.
#pragma once

#include <atomic>
#include <optional>
#include <utility>

#include "host/link/link.hpp"

namespace tetragauge {

struct BenchActions {
  bool home = false;
  std::optional<double> table_deg, slide_mm;        // to go from where the axis stands
  std::optional<std::pair<int, int>> mirrors_urad;  // first, second; they stay there
  double laser_s = 0;                               // on for so long, then off

  bool any() const { return home || table_deg || slide_mm || mirrors_urad || laser_s > 0; }
};

// In this order, each to its end; what an earlier host has left (end_what_runs) and a latched fault whose
// cause has gone are cleared first. What the machine refuses, or a fault on the way, is an error in its
// words. `stop`, which a signal may set, ends it early: laser off, axes stopped; only homing goes on to its
// end.
Status run_actions(Link& link, const BenchActions& actions, const std::atomic<bool>& stop);

// A scan, or a laser that is on or PAUSED, of a host that has gone: ended, with what nobody fetched of it.
// The state is then one of those in which the machine takes orders.
Status end_what_runs(Link& link);

}  // namespace tetragauge
