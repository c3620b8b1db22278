// SPDX-License-Identifier: Apache-2.0
// The times of a move's steps: speed up, cruise, slow down, jerk-limited (S-curve) or not (trapezoid).
//
//   MoveTimes move;
//   move.plan(steps, {speed, acceleration, jerk}, ticks_per_s);
//   while (move.given() < move.steps()) edge at start + move.next();   // in timer ticks
//
// Step k comes when the ideal position is k: the last one at the very end. Every time is computed from its
// own k, so nothing accumulates, and lies within one tick of the ideal one. Slowing down is speeding up read
// backwards.
//
// Instructions on a Cortex-M4 (-Os, counted under QEMU): next() 48 in cruise, 180 on a ramp, up to 6000
// within 0.1 ms and more of rest; plan() 13,000 to 28,000.
#pragma once

#include "firmware/motion/speed_ramp.hpp"

namespace tetragauge {

// Longest move: at 1 step/s its time still fits.
inline constexpr uint32_t kLongestMoveSteps = 20'000'000;

class MoveTimes {
 public:
  void plan(uint32_t steps, const AxisLimits& limits, uint32_t ticks_per_s);

  uint32_t steps() const { return steps_; }
  uint32_t given() const { return given_; }  // steps whose time next() has said
  uint64_t next();                           // of step given() + 1, ticks since the start

  // Slow down as soon as may be after step `at`, not given yet; a move that slows down then anyway is not
  // changed. Costs a thousand times as much as next(), so an interrupt that calls it is late with its steps:
  // copy the move, stop the copy a few steps ahead, let it catch up, and put it in place if the original has
  // not passed `at`.
  void stop_after(uint32_t at);
  void catch_up_with(const MoveTimes& original);

 private:
  void lay_out(const RampShape& shape, uint32_t steps);
  uint64_t cruise_time(uint32_t step) const;

  uint32_t steps_ = 0;
  uint32_t given_ = 0;
  uint64_t last_ = 0, interval_ = 0;  // fine time of the last step given, and what it took
  uint32_t ramp_steps_ = 0;           // whole steps within a ramp
  bool gentle_ = false;
  uint64_t end_ = 0;              // fine time of the last step
  uint64_t cruise_from_ = 0;      // fine time at which a cruise back to step 0 would have started
  uint64_t cruise_interval_ = 0;  // fine time of a step * 2^24
  SpeedRamp ramp_;
  RampShape shape_;
  double fine_per_s_ = 1;
};

}  // namespace tetragauge
