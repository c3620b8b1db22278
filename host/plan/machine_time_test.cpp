// SPDX-License-Identifier: GPL-3.0-or-later
// Times against the emulated machine's own clock.
#include "host/plan/machine_time.hpp"

#include "host/plan/test_parts.hpp"

namespace tetragauge {
namespace {

TEST(MachineTime, IsThatOfTheMachine) {
  auto session = start_session({.part = box_file()});
  ASSERT_TRUE(session) << session.error().message;
  const auto machine = read_machine(*session->link);
  ASSERT_TRUE(machine) << machine.error().message;
  // Long and short moves up and down of either axis, fine and coarse rasters, few and many samples.
  const struct {
    double table_deg, slide_mm, half_mm, pitch_mm;
    uint32_t samples;
  } kViews[] = {{0, 175, 10, 1, 36},  {170, 175, 10, 2, 8},   {160, 20, 20, 4, 120},
                {161, 21, 5, 0.5, 2}, {-150, 300, 10, 1, 36}, {-150, 299, 1, 50, 400}};
  ScanPlan all;
  MachineStance stance = homed_stance(*machine);
  for (const auto& v : kViews) {
    ScanPlan one;
    one.views.push_back(
        {v.table_deg, v.slide_mm, {-v.half_mm, v.half_mm, -v.half_mm, v.half_mm}, v.pitch_mm, v.samples});
    all.views.push_back(one.views.front());
    const auto predicted = plan_time_s(*machine, one, stance);
    ASSERT_TRUE(predicted) << predicted.error().message;
    const auto measured = run_scan(*session->link, one);
    ASSERT_TRUE(measured) << measured.error().message;
    // A tenth of a second for the start, the end and what the host answers between.
    EXPECT_NEAR(measured->counts.machine_time_s, *predicted, 0.02 * *predicted + 0.1) << v.table_deg;
    go_to(*machine, {v.table_deg, v.slide_mm}, stance);
  }
  const auto together = plan_time_s(*machine, all, stance);
  ASSERT_TRUE(together);
  const auto again = run_scan(*session->link, all);
  ASSERT_TRUE(again);
  EXPECT_NEAR(again->counts.machine_time_s, *together, 0.02 * *together + 0.1);
}

TEST(MachineTime, GoingDownTakesTheBacklashBesides) {
  const PlanningMachine machine = nominal_machine();
  const tg_AxisMotion& table = machine.config.stage.table;
  EXPECT_EQ(move_time_s(table, 100, 100), 0);
  EXPECT_GT(move_time_s(table, 1000, 0), move_time_s(table, 0, 1000));
  // A quarter turn: 9,000 steps at 9,000 steps/s and the ramps: speed over acceleration and acceleration over
  // jerk.
  EXPECT_NEAR(move_time_s(table, 0, 9000), 1 + 0.25 + 0.05, 1e-9);
}

}  // namespace
}  // namespace tetragauge
