// SPDX-License-Identifier: GPL-3.0-or-later
// What the planner has to know of a machine: where its head and cameras stand, what it reaches, how fast it
// is. The nominal one, or asked of a machine that is there.
#pragma once

#include "firmware/machine_config.hpp"
#include "host/link/link.hpp"
#include "host/session/head_geometry.hpp"

namespace tetragauge {

struct PlanningMachine {
  MachineConfig config;
  HeadGeometry head;
  MachineGeometry<double> geometry;
  uint32_t sample_period_ns = 30'000;
  uint32_t max_views = 256;
};

PlanningMachine nominal_machine();
Result<PlanningMachine> read_machine(Link& link);

}  // namespace tetragauge
