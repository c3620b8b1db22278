// SPDX-License-Identifier: GPL-3.0-or-later
// The order of places in which the stage travels least.
#pragma once

#include <vector>

#include "host/plan/machine_time.hpp"

namespace tetragauge {

// Indices of `places` in the order to go to them, from `stance`: the nearest next, then legs crossed over
// while that saves time (2-opt).
std::vector<size_t> order_views(const PlanningMachine& machine, const std::vector<StagePlace>& places,
                                const MachineStance& stance);

}  // namespace tetragauge
