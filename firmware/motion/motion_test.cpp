// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/axis_mover.hpp"

#include <gtest/gtest.h>

#include <random>

#include "firmware/hal/fake_board.hpp"

namespace tetragauge {
namespace {

class AxisTest : public testing::Test {
 protected:
  AxisTest() : axis(board, Axis::kSlide, Inputs::kSlideHome) {
    motion = {-200, 60'200, 20'000, 100'000, 4'000, 500, -400, 20, 0};
    axis.configure(motion);
    board.on_edge = [this](int, uint64_t, int direction) {
      up = direction > 0;
      lowest = std::min(lowest, board.carriage[1]);
      ++edges;
    };
  }
  // One edge, its interrupt, and what the main loop does then. False when none is scheduled.
  bool one_step() {
    if (board.step_edge[1] == FakeBoard::kNever) return false;
    board.now = std::max(board.now, board.step_edge[1]);
    board.make_edge(1);
    board.step_interrupt[1] = FakeBoard::kNever;
    axis.on_step_timer();
    axis.poll();
    return true;
  }
  void finish() {
    axis.poll();
    while (axis.busy()) {
      if (!one_step()) axis.poll();
    }
  }
  void stand_at(int64_t steps) { board.position[1] = board.carriage[1] = lowest = steps; }
  // Counted by the axis, against edges the motor got.
  void expect_position(int64_t offset) { ASSERT_EQ(board.position[1] - offset, axis.position_steps()); }

  FakeBoard board;
  tg_AxisMotion motion;
  AxisMover<FakeBoard> axis;
  bool up = false;
  int64_t lowest = 0;
  uint64_t edges = 0;
};

struct Drive {
  const char* name;
  uint32_t jerk;
  int64_t play;  // of the true machine; 20 steps are configured
};
void PrintTo(const Drive& drive, std::ostream* out) {
  *out << drive.name;
}

class Homing : public AxisTest, public testing::WithParamInterface<Drive> {
 protected:
  void SetUp() override {
    motion.jerk = GetParam().jerk;
    axis.configure(motion);
    board.play[1] = GetParam().play;
  }
};

TEST_P(Homing, FindsTheEdgeFromAnywhere) {
  for (const int64_t from : {5'000, 0, -999, -1'000, -1'001, -1'100}) {
    stand_at(from);  // the switch's true edge is at -1000
    axis.home();
    finish();
    EXPECT_EQ(axis.fault(), tg_FaultCode_FAULT_NONE);
    EXPECT_EQ(board.carriage[1], -999) << "the first step with the switch open";
    EXPECT_EQ(axis.position_steps(), -399) << "is the step above home_steps";
    EXPECT_EQ(axis.home_spread_steps(), 0u);
    EXPECT_GT(lowest, -1'200) << "the end switch, 200 below the edge, is not reached";
    EXPECT_TRUE(up);
  }
}

TEST_P(Homing, PutsTheCarriageInTheSamePlaceFromEitherSide) {
  stand_at(3'000);
  axis.home();
  finish();
  for (const int64_t other : {0, 2'000}) {
    ASSERT_TRUE(axis.move_to(other));
    finish();
    ASSERT_TRUE(axis.move_to(1'000));
    finish();
    EXPECT_EQ(board.carriage[1], -999 + 1'000 + 399) << "coming from " << other;
  }
}

TEST_P(Homing, ReportsHowWellTheSwitchRepeats) {
  stand_at(100);
  axis.home();
  // The switch opens 2 steps later at the second latch, 1 earlier at the third.
  const int64_t edge[] = {-1'000, -998, -1'001};
  size_t latch = 0;
  bool was_up = false;
  while (axis.busy()) {
    if (!one_step()) axis.poll();
    if (was_up && !up) board.slide_home = edge[std::min<size_t>(++latch, 2)];
    was_up = up;
  }
  EXPECT_EQ(axis.home_spread_steps(), 3u);
}

INSTANTIATE_TEST_SUITE_P(Drives, Homing,
                         testing::Values(Drive{"trapezoid", 0, 0}, Drive{"trapezoid_with_play", 0, 12},
                                         Drive{"s_curve", 4'000'000, 0},
                                         Drive{"s_curve_with_play", 4'000'000, 12}),
                         [](const auto& info) { return info.param.name; });

TEST_F(AxisTest, SaysWhenTheSwitchIsNotFoundOrStuck) {
  board.slide_home = -10'000'000;
  axis.home();
  finish();
  EXPECT_EQ(axis.fault(), tg_FaultCode_FAULT_HOME_NOT_FOUND);
  board.slide_home = 10'000'000;
  axis.home();
  finish();
  EXPECT_EQ(axis.fault(), tg_FaultCode_FAULT_HOME_STUCK);
}

TEST_F(AxisTest, RefusesTargetsBeyondTheSoftLimits) {
  EXPECT_FALSE(axis.move_to(-201));
  EXPECT_FALSE(axis.move_to(60'201));
  EXPECT_FALSE(axis.busy());
  EXPECT_TRUE(axis.move_to(-200));
  finish();
  EXPECT_EQ(axis.position_steps(), -200);
}

TEST_F(AxisTest, JogsWithinTheWholeTravelWhenTheHomeIsUnknown) {
  const int64_t travel = 60'200 + 400 + 2 * (20 + 50 + 10);
  axis.jog_to(1'000'000'000);
  finish();
  EXPECT_EQ(axis.position_steps(), travel);
}

// A million moves of all kinds: whole ones, stopped ones, halted ones, jogs; trapezoids and S-curves. The
// axis' count is always the number of edges the motor got.
TEST_F(AxisTest, PositionNeverDriftsOverAMillionMoves) {
  std::mt19937 random(2);
  axis.home();
  finish();
  const int64_t offset = board.position[1] - axis.position_steps();
  // Fast enough that short moves meet all of speeding up, cruise and slowing down.
  motion.speed = motion.homing_speed = 100'000;
  motion.acceleration = 50'000'000;
  uint64_t whole = 0, stopped = 0, halted = 0;
  for (int move = 0; move < 1'000'000; ++move) {
    if (move % 1'000 == 0) {
      motion.jerk = move % 2'000 == 0 ? 0 : 1'000'000'000u;
      motion.backlash_steps = move % 3'000 == 0 ? 5 : 0;
      axis.configure(motion);
    }
    const int64_t at = axis.position_steps();
    const int64_t reach = move % 500 == 0 ? 20'000 : 12;
    const int64_t target =
        std::clamp<int64_t>(at + static_cast<int64_t>(random() % (2 * reach + 1)) - reach, -200, 60'200);
    if (move % 7 == 0) {
      axis.jog_to(target);
    } else {
      ASSERT_TRUE(axis.move_to(target));
    }
    const unsigned what = random() % 8;
    if (what >= 2) {
      finish();
      ASSERT_EQ(axis.position_steps(), target);
      if (target != at) {
        ASSERT_TRUE(up || motion.backlash_steps == 0) << "backlash is always taken up from below";
      }
      ++whole;
    } else {
      const auto until = random() % (static_cast<unsigned>(std::abs(target - at)) + 2);
      for (uint64_t k = 0; k < until && axis.busy(); ++k) one_step();
      if (what == 0) {
        axis.stop();
        finish();
        ASSERT_LE(std::abs(axis.position_steps() - at), std::abs(target - at));
        ++stopped;
      } else {
        // Sometimes with the edge out and its interrupt still to come.
        const bool out = random() % 2 == 0 && board.step_edge[1] != FakeBoard::kNever;
        if (out) board.make_edge(1);
        axis.halt();
        if (out) axis.on_step_timer();
        ASSERT_FALSE(axis.busy());
        ASSERT_EQ(board.step_edge[1], FakeBoard::kNever) << "no edge after it";
        ++halted;
      }
    }
    ASSERT_EQ(board.position[1] - offset, axis.position_steps()) << "move " << move;
  }
  std::printf("%llu whole, %llu stopped, %llu halted moves, %llu edges: no step lost\n",
              static_cast<unsigned long long>(whole), static_cast<unsigned long long>(stopped),
              static_cast<unsigned long long>(halted), static_cast<unsigned long long>(edges));
  EXPECT_GT(stopped, 100'000u);
  EXPECT_GT(halted, 100'000u);
  EXPECT_EQ(axis.steps_late(), 0u);
}

TEST_F(AxisTest, StopSlowsDownAndEndsGoingUp) {
  motion.jerk = 4'000'000;
  axis.configure(motion);
  stand_at(30'000);
  const int64_t offset = 30'000;
  // Full speed is reached after 20000 (0.2 + 0.025) / 2 = 2250 steps, and the same takes it back to rest.
  for (const int64_t target : {20'000, -30'000}) {
    motion.min_steps = -40'000;
    axis.configure(motion);
    ASSERT_TRUE(axis.move_to(target));
    for (int k = 0; k < 9'000; ++k) one_step();
    const int64_t at = axis.position_steps();
    axis.stop();
    ASSERT_TRUE(axis.busy());
    finish();
    const int64_t way = std::abs(axis.position_steps() - at);
    EXPECT_GE(way, 2'250 - 20);
    EXPECT_LE(way, 2'250 + 20 + 2 + 20'000 / 1'000 * kStopPlanningMs);
    EXPECT_TRUE(up);
    ASSERT_EQ(board.position[1] - offset, axis.position_steps());
  }
}

}  // namespace
}  // namespace tetragauge
