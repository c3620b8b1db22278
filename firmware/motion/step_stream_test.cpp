// SPDX-License-Identifier: Apache-2.0
// Both axes at 200,000 steps/s at once while points stream to the host and every interrupt comes late.
#include <gtest/gtest.h>

#include <vector>

#include "firmware/motion/ideal_move.hpp"
#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

struct FastMachine {
  const char* name;
  uint32_t jerk;
};
void PrintTo(const FastMachine& machine, std::ostream* out) {
  *out << machine.name;
}

class StepStream : public testing::TestWithParam<FastMachine> {
 protected:
  void SetUp() override {
    host.connect();
    MachineConfig config = nominal_config();
    tg_StageConfig& stage = config.stage;
    for (tg_AxisMotion* axis : {&stage.table, &stage.slide}) {
      axis->speed = 200'000;
      axis->acceleration = 2'000'000;
      axis->jerk = GetParam().jerk;
    }
    stage.table.max_steps = 60'000;
    tg_HostMessage set = tg_HostMessage_init_zero;
    set.which_body = tg_HostMessage_set_config_tag;
    ASSERT_TRUE(get_part(config, tg_ConfigPart_CONFIG_STAGE, &set.body.set_config));
    ASSERT_EQ(host.ask(set).which_body, tg_MachineMessage_done_tag);
    ASSERT_TRUE(host.home()) << host.trouble();
    limits = {200'000, 2'000'000, GetParam().jerk};
  }
  TestHost host;
  AxisLimits limits;
};

TEST_P(StepStream, EdgesAreExactWhileInterruptsAreLateAndPointsFlow) {
  // From one end of the axes to the other, table 50,000 steps and slide 60,000, both upwards.
  tg_View low = small_view(), high = small_view();
  low.table_udeg = 0;
  low.slide_um = 0;
  high.table_udeg = 500'000'000;
  high.slide_um = 300'000;
  std::vector<uint64_t> edges[kAxes];
  bool second_move = false;
  uint32_t items_before = 0, items_on_the_way = 0;
  std::mt19937 random(5);
  // Late by up to 4.8 us of the 5 us between two steps.
  host.board.interrupt_latency = [&] { return random() % 4'800; };
  host.board.line_room = 4;  // bytes a visit: the line is always busy
  host.board.on_edge = [&](int axis, uint64_t tick, int) {
    if (host.board.times_laser_on >= kSmallViewRays) {
      if (!second_move) items_before = host.items;
      second_move = true;
      edges[axis].push_back(tick);
    }
  };
  host.credits = false;  // the first view's points wait
  bool sent = false;
  host.after_every_event = [&] {
    if (second_move && !sent) {
      sent = host.credits = true;
      host.send_credit();
    }
    if (second_move && edges[1].size() < 60'000) items_on_the_way = host.items - items_before;
  };
  ASSERT_TRUE(host.scan({low, high}));
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 60)) << host.trouble();
  EXPECT_EQ(host.beams.size(), 2 * kSmallViewRays);
  EXPECT_GE(items_on_the_way, 2u) << "points went out while the stage moved";

  const uint32_t steps[kAxes] = {50'000, 60'000};
  for (int axis = 0; axis < kAxes; ++axis) {
    ASSERT_EQ(edges[axis].size(), steps[axis]);
    const IdealMove ideal(steps[axis], limits);
    long double low_error = 1e9L, high_error = -1e9L;
    for (uint32_t k = 1; k <= steps[axis]; ++k) {
      const long double error = static_cast<long double>(edges[axis][k - 1] - edges[axis][0]) -
                                1e9L * (ideal.step_time_s(k) - ideal.step_time_s(1));
      low_error = std::min(low_error, error);
      high_error = std::max(high_error, error);
    }
    // Relative to each other, two edges are off by at most a tick each way.
    EXPECT_LT(high_error - low_error, 2);
    std::printf("axis %d: %u edges, %.3f to %.3f ticks of 1 ns off\n", axis, steps[axis],
                static_cast<double>(low_error), static_cast<double>(high_error));
    // They did run at full speed at the same time.
    EXPECT_EQ(edges[axis][25'001] - edges[axis][25'000], 5'000u);
    EXPECT_GT(edges[0].back(), edges[1].front());
  }
}

INSTANTIATE_TEST_SUITE_P(Drives, StepStream,
                         testing::Values(FastMachine{"trapezoid", 0}, FastMachine{"s_curve", 100'000'000}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace tetragauge
