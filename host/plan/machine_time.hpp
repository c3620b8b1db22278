// SPDX-License-Identifier: GPL-3.0-or-later
// How long the machine takes: the one place where the host says so. By the firmware's own rules: its ramps
// (firmware/motion/speed_ramp.hpp), its settling (firmware/measure/settle.hpp), the order of a ray in
// firmware/scan/scan_runner.hpp.
#pragma once

#include <span>

#include "host/plan/planning_machine.hpp"

namespace tetragauge {

// Where stage and mirrors stand.
struct MachineStance {
  int64_t table_steps = 0, slide_steps = 0;
  int32_t a_urad = 0, b_urad = 0;
};

struct StagePlace {
  double table_deg = 0, slide_mm = 0;
};

// As homing leaves it.
MachineStance homed_stance(const PlanningMachine& machine);

// One axis, with the way back that takes up the backlash.
double move_time_s(const tg_AxisMotion& motion, int64_t from_steps, int64_t to_steps);
// Both axes together.
double travel_time_s(const PlanningMachine& machine, const MachineStance& stance, const StagePlace& to);
// One ray, the mirrors having to turn by `step_urad` for it.
double ray_time_s(const PlanningMachine& machine, uint32_t samples, int32_t step_urad);
// Stands the stage there.
void go_to(const PlanningMachine& machine, const StagePlace& place, MachineStance& stance);
// Moving there, and all its rays; `stance` becomes the one at its end.
double view_time_s(const PlanningMachine& machine, const tg_View& view, MachineStance& stance);

// From the start of the scan to its end. Error: a window beyond the mirrors' limit.
Result<double> plan_time_s(const PlanningMachine& machine, const ScanPlan& plan, MachineStance stance);

}  // namespace tetragauge
