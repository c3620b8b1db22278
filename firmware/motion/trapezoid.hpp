// SPDX-License-Identifier: Apache-2.0
// The times of a move's steps: speed up, cruise, slow down, all in integers.
//
//   Trapezoid move;
//   move.plan(steps, {speed, acceleration});
//   for (uint32_t k = 1; k <= move.steps(); ++k) edge at start + move.step_time_ns(k);
//
// Step k of a constant acceleration a from rest comes at sqrt(2 k / a); slowing down is the same read
// backwards. Each time is computed from its own k, so nothing accumulates.
#pragma once

#include <cstdint>

namespace tetragauge {

struct AxisSpeed {
  uint32_t speed = 0;         // steps/s
  uint32_t acceleration = 0;  // steps/s^2
};

// The longest time to full speed that the 64-bit times allow (2e18 k / a stays below 2^64 for k = speed^2 / 2
// a).
inline constexpr uint32_t kLongestSpeedUpS = 4;

class Trapezoid {
 public:
  void plan(uint32_t steps, AxisSpeed limits);
  uint32_t steps() const { return steps_; }
  uint64_t step_time_ns(uint32_t step) const;  // since the start; 1 <= step <= steps()

  // Slow down from `step`, just done; the move becomes shorter.
  void stop_after(uint32_t step);

 private:
  uint64_t ramp_ns(uint32_t step) const;  // sqrt(2 step / a)

  uint64_t ns2_per_step_ = 0;  // 2e18 / a
  uint32_t speed_ = 1;
  uint32_t steps_ = 0;
  uint32_t ramp_steps_ = 0;  // of speeding up
  uint32_t slow_from_ = 0;   // steps after this one slow down
  uint64_t ramp_end_ns_ = 0;
  uint64_t end_ns_ = 0;
};

// Largest r with r r <= x.
uint64_t integer_square_root(uint64_t x);

}  // namespace tetragauge
