// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "firmware/hal/fake_board.hpp"
#include "firmware/motion/axis_mover.hpp"

namespace tetragauge {
namespace {

TEST(IntegerSquareRoot, IsTheLargestWhoseSquareFits) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 100'000; ++trial) {
    const uint64_t x = random() >> (random() % 64);
    const uint64_t r = integer_square_root(x);
    EXPECT_LE(r * r, x);
    // (r + 1)^2 > x without overflow.
    EXPECT_GT(2 * r + 1, x - r * r);
  }
  EXPECT_EQ(integer_square_root(~uint64_t{0}), 0xFFFFFFFFu);
}

// The times of a continuous trapezoid, in long double.
long double ideal_ns(uint32_t step, uint32_t steps, AxisSpeed limits) {
  const long double v = limits.speed, a = limits.acceleration;
  const long double ramp = std::floor(v * v / (2 * a)) < steps / 2 ? std::floor(v * v / (2 * a)) : steps / 2;
  const long double ramp_s = std::sqrt(2 * ramp / a), cruise_s = (steps - 2 * ramp) / v;
  if (step <= ramp) return 1e9L * std::sqrt(2 * step / a);
  if (step <= steps - ramp) return 1e9L * (ramp_s + (step - ramp) / v);
  return 1e9L * (2 * ramp_s + cruise_s - std::sqrt(2 * (steps - step) / a));
}

TEST(Trapezoid, EveryStepWithinTwoNanosecondsOfTheIdealOne) {
  const AxisSpeed speeds[] = {{9'000, 36'000}, {20'000, 100'000}, {200'000, 400'000}, {500, 100'000}, {1, 1}};
  for (const AxisSpeed& limits : speeds) {
    for (const uint32_t steps : {1u, 2u, 3u, 10u, 999u, 1'000u, 40'000u, 150'000u}) {
      Trapezoid move;
      move.plan(steps, limits);
      ASSERT_EQ(move.steps(), steps);
      uint64_t before = 0;
      for (uint32_t k = 1; k <= steps; ++k) {
        const uint64_t time = move.step_time_ns(k);
        ASSERT_NEAR(static_cast<double>(time - ideal_ns(k, steps, limits)), 0,
                    2.0 + 1e-10 * static_cast<double>(time))
            << k << " of " << steps;
        // Never faster than allowed, but for rounding.
        ASSERT_GE(time - before + 2, 1'000'000'000u / limits.speed);
        before = time;
      }
    }
  }
}

TEST(Trapezoid, StopsOnTheWayWithoutAJump) {
  const AxisSpeed limits{10'000, 50'000};  // 1000 steps of ramp
  for (const uint32_t at : {1u, 500u, 999u, 1'000u, 3'000u, 8'999u, 9'500u}) {
    Trapezoid move;
    move.plan(10'000, limits);
    const uint64_t last = move.step_time_ns(at) - (at > 1 ? move.step_time_ns(at - 1) : 0);
    move.stop_after(at);
    EXPECT_EQ(move.steps(), at < 1'000 ? 2 * at : at < 9'000 ? at + 1'000 : 10'000);
    if (at == move.steps()) continue;
    const uint64_t next = move.step_time_ns(at + 1) - move.step_time_ns(at);
    EXPECT_NEAR(static_cast<double>(next), static_cast<double>(last), 0.5 * static_cast<double>(last)) << at;
  }
}

class AxisTest : public testing::Test {
 protected:
  AxisTest() : axis(board, Axis::kSlide, Inputs::kSlideHome) {
    motion = {-200, 60'200, 20'000, 100'000, 4'000, 500, -400, 20, 0};
    axis.configure(motion);
  }
  void finish() {
    while (axis.busy() && board.step_alarm[1] != FakeBoard::kNever) {
      board.now = board.step_alarm[1];
      board.step_alarm[1] = FakeBoard::kNever;
      const int64_t before = board.position[1];
      axis.on_step_timer();
      EXPECT_EQ(std::abs(board.position[1] - before), 1) << "one step an interrupt";
      up = board.position[1] > before;
      lowest = std::min(lowest, board.position[1]);
    }
  }
  FakeBoard board;
  tg_AxisMotion motion;
  AxisMover<FakeBoard> axis;
  bool up = false;
  int64_t lowest = 0;
};

TEST_F(AxisTest, HomesFromAnywhere) {
  for (const int64_t from : {5'000, 0, -999, -1'000, -1'001, -1'100}) {
    board.position[1] = from;  // the switch's true edge is at -1000
    lowest = from;
    axis.home();
    finish();
    EXPECT_FALSE(axis.busy());
    EXPECT_EQ(axis.fault(), tg_FaultCode_FAULT_NONE);
    EXPECT_EQ(board.position[1], -999) << "the first step with the switch open";
    EXPECT_EQ(axis.position_steps(), -399) << "is the step above home_steps";
    EXPECT_EQ(axis.home_spread_steps(), 0u);
    EXPECT_GT(lowest, -1'200) << "the end switch, 200 below the edge, is not reached";
    EXPECT_TRUE(up);
  }
}

TEST_F(AxisTest, SaysWhenTheSwitchIsNotFoundOrStuck) {
  board.slide_home = -10'000'000;
  axis.home();
  finish();
  EXPECT_FALSE(axis.busy());
  EXPECT_EQ(axis.fault(), tg_FaultCode_FAULT_HOME_NOT_FOUND);
  board.slide_home = 10'000'000;
  axis.home();
  finish();
  EXPECT_EQ(axis.fault(), tg_FaultCode_FAULT_HOME_STUCK);
}

TEST_F(AxisTest, CountsEveryStepAndEndsGoingUp) {
  axis.home();
  finish();
  const int64_t offset = board.position[1] - axis.position_steps();
  std::mt19937 random(2);
  int64_t moves = 0;
  for (int trial = 0; trial < 3'000; ++trial) {
    const int64_t target = -200 + static_cast<int64_t>(random() % (trial % 10 == 0 ? 60'000 : 400));
    const bool moves_at_all = target != axis.position_steps();
    axis.move_to(target);
    finish();
    ASSERT_FALSE(axis.busy());
    ASSERT_EQ(axis.position_steps(), target);
    ASSERT_EQ(board.position[1] - offset, target);
    ASSERT_TRUE(up || !moves_at_all) << "backlash is always taken up from below";
    ++moves;
  }
  EXPECT_EQ(moves, 3'000);
}

}  // namespace
}  // namespace tetragauge
