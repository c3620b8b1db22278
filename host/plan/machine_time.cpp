// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/machine_time.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/measure/settle.hpp"
#include "firmware/motion/speed_ramp.hpp"

namespace tetragauge {
namespace {

double leg_time_s(const tg_AxisMotion& motion, int64_t steps) {
  if (steps == 0) return 0;
  const AxisLimits limits{motion.speed, motion.acceleration, motion.jerk};
  const double distance = static_cast<double>(steps);
  const RampShape ramp = ramp_to_speed(limits);
  if (2 * ramp.distance() > distance) return 2 * ramp_over(distance / 2, limits).duration();
  return 2 * ramp.duration() + (distance - 2 * ramp.distance()) / ramp.speed();
}

}  // namespace

MachineStance homed_stance(const PlanningMachine& machine) {
  return {machine.config.stage.table.home_steps + 1, machine.config.stage.slide.home_steps + 1, 0, 0};
}

double move_time_s(const tg_AxisMotion& motion, int64_t from_steps, int64_t to_steps) {
  if (to_steps >= from_steps) return leg_time_s(motion, to_steps - from_steps);
  return leg_time_s(motion, from_steps - to_steps + motion.backlash_steps) +
         leg_time_s(motion, motion.backlash_steps);
}

double ray_time_s(const PlanningMachine& machine, uint32_t samples, int32_t step_urad) {
  const tg_MeasureConfig& measure = machine.config.measure;
  // Laser off, on, off: as many samples with light as without.
  return 1e-6 * (settling_of(measure, step_urad).us + 2.0 * measure.laser_delay_us) +
         1e-9 * (2.0 * samples * machine.sample_period_ns);
}

void go_to(const PlanningMachine& machine, const StagePlace& place, MachineStance& stance) {
  stance.table_steps = table_steps(machine.config, static_cast<int32_t>(std::lround(1e6 * place.table_deg)));
  stance.slide_steps = slide_steps(machine.config, static_cast<int32_t>(std::lround(1e3 * place.slide_mm)));
}

double travel_time_s(const PlanningMachine& machine, const MachineStance& stance, const StagePlace& to) {
  MachineStance there = stance;
  go_to(machine, to, there);
  return std::max(move_time_s(machine.config.stage.table, stance.table_steps, there.table_steps),
                  move_time_s(machine.config.stage.slide, stance.slide_steps, there.slide_steps));
}

double view_time_s(const PlanningMachine& machine, const tg_View& view, MachineStance& stance) {
  const StagePlace place{1e-6 * view.table_udeg, 1e-3 * view.slide_um};
  double time_s = travel_time_s(machine, stance, place) + 1e-6 * machine.config.measure.stage_settle_us;
  const auto step_time = [&](int32_t step_urad) { return ray_time_s(machine, view.samples, step_urad); };
  time_s += step_time(
      std::max(std::abs(view.a_first_urad - stance.a_urad), std::abs(view.b_first_urad - stance.b_urad)));
  time_s += static_cast<double>(view.rows) * (view.columns - 1) * step_time(std::abs(view.a_step_urad));
  time_s += (view.rows - 1) * step_time(std::abs(view.b_step_urad));
  go_to(machine, place, stance);
  // Every other row runs backwards.
  stance.a_urad = view.a_first_urad +
                  (view.rows % 2 == 1 ? static_cast<int32_t>(view.columns - 1) * view.a_step_urad : 0);
  stance.b_urad = view.b_first_urad + static_cast<int32_t>(view.rows - 1) * view.b_step_urad;
  return time_s;
}

Result<double> plan_time_s(const PlanningMachine& machine, const ScanPlan& plan, MachineStance stance) {
  double time_s = 0;
  for (const PlannedView& planned : plan.views) {
    const auto view = lay_raster(machine.head, planned);
    if (!view) return view.error();
    time_s += view_time_s(machine, *view, stance);
  }
  return time_s;
}

}  // namespace tetragauge
