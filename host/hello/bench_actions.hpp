// SPDX-License-Identifier: GPL-3.0-or-later
// What somebody who builds a machine has it do, one thing at a time, with an instrument in hand.
#pragma once

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

// In this order, each to its end; a latched fault whose cause has gone is cleared first. What the machine
// refuses, or a fault on the way, is an error in its words.
Status run_actions(Link& link, const BenchActions& actions);

}  // namespace tetragauge
