// SPDX-License-Identifier: Apache-2.0
// Speeding up from rest: the time at which a distance has been covered.
//
// Jerk-limited: acceleration rises by `jerk`, stays, falls by `jerk` to nothing (phases 0, 1, 2); with jerk 0
// it is there at once (phase 0 alone). In each phase the position is a cubic of time. Planning is done in
// double, once a move; finding a step's time is integer arithmetic alone while steps come quickly (Newton's
// method with the last interval for the slope: one evaluation of the cubic a step), and a few Newton steps in
// float near rest, where there is time.
//
// Times are in fine units, 1/256 of a timer tick, so that rounding to the tick is the only error that counts.
#pragma once

#include <cstdint>

namespace tetragauge {

struct AxisLimits {
  uint32_t speed = 1;         // steps/s
  uint32_t acceleration = 1;  // steps/s^2
  uint32_t jerk = 0;          // steps/s^3; 0: none, acceleration jumps
};

// Longest time to full speed that the numbers below have room for.
inline constexpr uint32_t kLongestSpeedUpS = 4;
inline constexpr uint32_t kFinePerTick = 256;

// Durations in seconds.
struct RampShape {
  double acceleration = 1, jerk = 0;
  double rise = 0;      // of the acceleration, and of its fall; 0 with jerk 0
  double constant = 0;  // with full acceleration

  double speed() const;     // at its end, steps/s
  double duration() const;  // s
  double distance() const;  // steps
};

// To the speed limit.
RampShape ramp_to_speed(const AxisLimits& limits);
// The one that covers `distance` steps when it does not get to the speed limit.
RampShape ramp_over(double distance, const AxisLimits& limits);
// The same ramp until `time` s, then its acceleration falls to nothing at once or by `jerk`.
RampShape ramp_cut_at(double time, const RampShape& shape);

class SpeedRamp {
 public:
  void plan(const RampShape& shape, double fine_per_s);

  // When `steps` (at most the ramp's distance) have been covered; `guess` and `interval`, the time one step
  // takes about there, speed the search up (0, 0: nothing is known).
  uint64_t time_at(uint32_t steps, uint64_t guess, uint64_t interval);

 private:
  static constexpr int kPhases = 3;
  // Distances are steps * 2^40. In the phase, x = (time - begin) << shift is a fraction of 2^64, and
  // position = begin_position + x (c1 + x (c2 +- x c3)).
  struct Phase {
    uint64_t begin = 0, end = 0;
    uint64_t begin_position = 0, end_position = 0;
    uint64_t c1 = 0, c2 = 0, c3 = 0;
    int shift = 1;
    bool falling = false;  // acceleration falls: - c3
  };
  static uint64_t position(const Phase& phase, uint64_t time);
  static uint64_t newton(const Phase& phase, uint64_t position, uint64_t time);

  Phase phase_[kPhases];
  int at_ = 0;  // the phase of the last time asked for
};

// y^n = x for n 2 or 3, in arithmetic that every processor rounds alike.
double nth_root(double x, int n);

}  // namespace tetragauge
