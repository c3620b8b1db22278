// SPDX-License-Identifier: GPL-3.0-or-later
// The options of the planner, shared by `plan` and `measure`; the pitch is each command's own.
#pragma once

#include "host/cli/machine_options.hpp"
#include "host/plan/plan_part.hpp"

namespace tetragauge::cli {

struct PlanArguments {
  PlanPartOptions options;

  void add(CLI::App& command);
  Status check() const;
};

// "6 views from 3 places of the stage, 80 s predicted; 1 of 15 faces cannot be seen"
std::string plan_sentence(const PartPlan& plan);

}  // namespace tetragauge::cli
