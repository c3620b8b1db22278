// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/move_times.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "firmware/motion/ideal_move.hpp"

namespace tetragauge {
namespace {

TEST(NthRoot, IsTheRoot) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 2'000; ++trial) {
    const double x = std::exp(std::uniform_real_distribution<double>(-60, 60)(random));
    EXPECT_NEAR(nth_root(x, 2) / std::sqrt(x), 1, 1e-15) << x;
    EXPECT_NEAR(nth_root(x, 3) / std::cbrt(x), 1, 1e-15) << x;
  }
  EXPECT_EQ(nth_root(0, 2), 0);
}

struct Case {
  AxisLimits limits;
  uint32_t steps;
};

std::vector<Case> cases() {
  const AxisLimits limits[] = {
      {9'000, 36'000, 0},
      {20'000, 100'000, 0},
      {200'000, 400'000, 0},
      {500, 100'000, 0},
      {1, 1, 0},
      {200'000, 4'000'000'000, 0},
      {9'000, 36'000, 720'000},
      {20'000, 100'000, 4'000'000},
      {200'000, 400'000, 2'000'000},
      {200'000, 400'000, 400'000},
      {200'000, 100'000, 50'000'000},
      {500, 100'000, 1'000'000},
      {1, 1, 1},
      {200'000, 4'000'000, 4'000'000'000},
  };
  std::vector<Case> all;
  for (const AxisLimits& one : limits) {
    for (const uint32_t steps : {1u, 2u, 3u, 4u, 7u, 10u, 999u, 1'000u, 40'000u, 150'000u}) {
      all.push_back({one, steps});
    }
  }
  std::mt19937 random(3);
  const auto any = [&](double low, double high) {
    return static_cast<uint32_t>(
        std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random)));
  };
  while (all.size() < 400) {
    Case one{{any(1, 200'000), any(1, 1e7), random() % 4 == 0 ? 0 : any(1, 1e9)}, any(1, 20'000)};
    if (IdealMove(one.steps, one.limits).ramp_s() <= kLongestSpeedUpS) all.push_back(one);
  }
  return all;
}

// On the two clocks there are: nanoseconds in emulation, 84 MHz on the chip.
class EveryStep : public testing::TestWithParam<uint32_t> {};

TEST_P(EveryStep, ComesWithinOneTickOfTheIdealTime) {
  const uint32_t ticks_per_s = GetParam();
  long double worst = 0;
  for (const Case& one : cases()) {
    const IdealMove ideal(one.steps, one.limits);
    MoveTimes move;
    move.plan(one.steps, one.limits, ticks_per_s);
    ASSERT_EQ(move.steps(), one.steps);
    uint64_t before = 0;
    for (uint32_t k = 1; k <= one.steps; ++k) {
      const uint64_t time = move.next();
      // Long moves: all of both ends, and samples between.
      if (k > 2'000 && k + 2'000 < one.steps && k % 37 != 0) {
        before = time;
        continue;
      }
      const long double error = static_cast<long double>(time) - ideal.step_time_s(k) * ticks_per_s;
      ASSERT_LT(std::abs(error), 1) << "step " << k << " of " << one.steps << ", speed " << one.limits.speed
                                    << ", acceleration " << one.limits.acceleration << ", jerk "
                                    << one.limits.jerk;
      worst = std::max(worst, std::abs(error));
      // Never faster than allowed, but for rounding.
      ASSERT_GE((time - before + 2) * uint64_t{one.limits.speed}, ticks_per_s);
      before = time;
    }
    ASSERT_EQ(move.given(), one.steps);
  }
  std::printf("worst step: %.3f ticks of 1/%u s off\n", static_cast<double>(worst), ticks_per_s);
}

INSTANTIATE_TEST_SUITE_P(Clocks, EveryStep, testing::Values(1'000'000'000u, 84'000'000u));

TEST(MoveTimes, StopsOnTheWayWithoutAJump) {
  const AxisLimits all_limits[] = {
      {10'000, 50'000, 0}, {10'000, 50'000, 1'000'000}, {10'000, 50'000, 100'000}};
  for (const AxisLimits& limits : all_limits) {
    const double a = limits.acceleration;
    for (const uint32_t at :
         {1u, 2u, 40u, 500u, 999u, 1'000u, 1'400u, 3'000u, 7'000u, 8'999u, 9'500u, 9'999u}) {
      // Planned on a copy while the original goes on, as an axis does it.
      MoveTimes original, stopped;
      original.plan(10'000, limits, 1'000'000'000);
      for (uint32_t k = 3; k < at; ++k) original.next();
      stopped = original;
      stopped.stop_after(at);
      while (original.given() + 1 < at) original.next();
      stopped.catch_up_with(original);
      ASSERT_LE(stopped.steps(), 10'000u);
      ASSERT_GE(stopped.steps(), at);
      // The edge `at` is where it was, and what follows obeys the limits: speed, and acceleration as the
      // change of mean speed from one interval to the next.
      uint64_t time = stopped.next();
      ASSERT_NEAR(static_cast<double>(time), static_cast<double>(original.next()), 1) << at;
      uint64_t before = time;
      double speed = 0;
      uint64_t middle = 0;
      uint32_t rising = 0;
      while (stopped.given() < stopped.steps()) {
        time = stopped.next();
        ASSERT_GT(time, before);
        const double now = 1e9 / static_cast<double>(time - before);
        ASSERT_LE(now, limits.speed * 1.0001);
        if (speed > 0) {
          const double seconds = 1e-9 * static_cast<double>((time + before) / 2 - middle);
          const double rounding = 2 * now * now * 1e-9;  // a nanosecond of either interval
          ASSERT_LE(std::abs(now - speed), a * seconds * 1.0001 + rounding)
              << "after " << at << ", step " << stopped.given();
          rising += now > speed * 1.0001 ? 1 : 0;
        }
        speed = now;
        middle = (time + before) / 2;
        before = time;
      }
      if (limits.jerk == 0) {
        EXPECT_EQ(rising, 0u) << "no step faster than the one before";
      }
      // As short as the limits allow: from speed v the way is v^2 / 2a, and v a / 2j more with jerk (twice
      // when the acceleration must be taken back first).
      const double v = limits.speed, j = limits.jerk;
      const double way = v * v / (2 * a) + (j > 0 ? v * a / j * 1.5 : 0) + 2;
      EXPECT_LE(stopped.steps() - at, way) << at;
      // It ends slowly: the last interval is that of a start.
      MoveTimes start;
      start.plan(10'000, limits, 1'000'000'000);
      if (stopped.steps() - at > 1) {
        EXPECT_NEAR(1e9 / speed, static_cast<double>(start.next()), 2.0) << at;
      }
    }
  }
}

TEST(MoveTimes, AStopMayComeTooLateToMatter) {
  MoveTimes move, again;
  const AxisLimits limits{1'000, 10'000, 100'000};
  move.plan(500, limits, 84'000'000);
  again.plan(500, limits, 84'000'000);
  for (uint32_t k = 1; k <= 460; ++k) ASSERT_EQ(move.next(), again.next());
  again.stop_after(470);  // slows down already
  ASSERT_EQ(again.steps(), 500u);
  while (move.given() < 500) ASSERT_EQ(move.next(), again.next());
}

}  // namespace
}  // namespace tetragauge
