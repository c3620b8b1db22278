// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/trapezoid.hpp"

namespace tetragauge {

uint64_t integer_square_root(uint64_t x) {
  uint64_t root = 0;
  for (uint64_t bit = uint64_t{1} << 62; bit != 0; bit >>= 2) {
    if (x >= root + bit) {
      x -= root + bit;
      root = (root >> 1) + bit;
    } else {
      root >>= 1;
    }
  }
  return root;
}

uint64_t Trapezoid::ramp_ns(uint32_t step) const {
  return integer_square_root(ns2_per_step_ * step);
}

void Trapezoid::plan(uint32_t steps, AxisSpeed limits) {
  const uint64_t speed = limits.speed;
  const uint64_t acceleration = limits.acceleration;
  ns2_per_step_ = uint64_t{2'000'000'000'000'000'000} / acceleration;
  speed_ = limits.speed;
  steps_ = steps;
  const uint64_t to_full_speed = speed * speed / (2 * acceleration);
  ramp_steps_ = static_cast<uint32_t>(to_full_speed < steps / 2 ? to_full_speed : steps / 2);
  slow_from_ = steps - ramp_steps_;
  ramp_end_ns_ = ramp_ns(ramp_steps_);
  const uint64_t cruise_ns = uint64_t{1'000'000'000} * (slow_from_ - ramp_steps_) / speed;
  end_ns_ = ramp_end_ns_ + cruise_ns + ramp_end_ns_;
}

uint64_t Trapezoid::step_time_ns(uint32_t step) const {
  if (step > slow_from_) return end_ns_ - ramp_ns(steps_ - step);
  if (step <= ramp_steps_) return ramp_ns(step);
  return ramp_end_ns_ + uint64_t{1'000'000'000} * (step - ramp_steps_) / speed_;
}

void Trapezoid::stop_after(uint32_t step) {
  if (step >= slow_from_) return;
  const uint64_t now = step_time_ns(step);
  const uint32_t slow_steps = step < ramp_steps_ ? step : ramp_steps_;
  slow_from_ = step;
  steps_ = step + slow_steps;
  end_ns_ = now + ramp_ns(slow_steps);
}

}  // namespace tetragauge
