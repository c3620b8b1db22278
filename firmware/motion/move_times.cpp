// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/move_times.hpp"

namespace tetragauge {
namespace {

constexpr int kCruiseBits = 24;

// Smallest whole number not below x; x is positive. What a sum of roundings adds to a whole number is none.
uint32_t whole_above(double x) {
  const double nearly = x - x * 1e-14;
  const uint32_t below = static_cast<uint32_t>(nearly);
  return below < nearly ? below + 1 : below;
}

}  // namespace

void MoveTimes::plan(uint32_t steps, const AxisLimits& limits, uint32_t ticks_per_s) {
  fine_per_s_ = static_cast<double>(ticks_per_s) * kFinePerTick;
  given_ = 0;
  last_ = interval_ = 0;
  RampShape shape = ramp_to_speed(limits);
  if (2 * shape.distance() > steps) shape = ramp_over(steps / 2.0, limits);
  lay_out(shape, steps);
}

void MoveTimes::lay_out(const RampShape& shape, uint32_t steps) {
  shape_ = shape;
  steps_ = steps;
  ramp_.plan(shape, fine_per_s_);
  const double distance = shape.distance();
  ramp_steps_ = static_cast<uint32_t>(distance);
  if (ramp_steps_ > steps / 2) ramp_steps_ = steps / 2;
  const double interval = fine_per_s_ / shape.speed();
  // Speed changes by under a hundredth from one step to the next at the peak. Otherwise the last interval
  // tells nothing about the slope behind the turn, where slowing down begins.
  gentle_ = shape.acceleration * 100 < shape.speed() * shape.speed();
  const double cruise = (steps - 2 * distance) * interval;
  cruise_interval_ = static_cast<uint64_t>(interval * (1 << kCruiseBits) + 0.5);
  cruise_from_ = static_cast<uint64_t>(shape.duration() / 2 * fine_per_s_ + 0.5);
  end_ = static_cast<uint64_t>(2 * shape.duration() * fine_per_s_ + (cruise > 0 ? cruise : 0) + 0.5);
}

uint64_t MoveTimes::cruise_time(uint32_t step) const {
  const uint64_t low = uint64_t{step} * static_cast<uint32_t>(cruise_interval_);
  const uint64_t high = uint64_t{step} * static_cast<uint32_t>(cruise_interval_ >> 32);
  return cruise_from_ + (high << (32 - kCruiseBits)) + (low >> kCruiseBits);
}

uint64_t MoveTimes::next() {
  const uint32_t step = ++given_;
  const uint32_t left = steps_ - step;
  uint64_t time = 0;
  if (step <= ramp_steps_) {
    time = ramp_.time_at(step, last_ + interval_, interval_);
  } else if (left > ramp_steps_) {
    time = cruise_time(step);
  } else {
    const uint64_t guess = last_ + interval_;
    const bool turns = !gentle_ && (left == ramp_steps_ || step == ramp_steps_ + 1);
    time = end_ - ramp_.time_at(left, guess < end_ ? end_ - guess : 0, turns ? 0 : interval_);
  }
  interval_ = time - last_;
  last_ = time;
  return (time + kFinePerTick / 2) / kFinePerTick;
}

void MoveTimes::stop_after(uint32_t at) {
  if (at >= steps_) return;
  RampShape shape = shape_;
  if (at <= ramp_steps_) {
    SpeedRamp search = ramp_;
    const double time = static_cast<double>(search.time_at(at, 0, 0)) / fine_per_s_;
    shape = ramp_cut_at(time, shape_);
  }
  const double ramp = shape.distance();
  const uint32_t steps = whole_above((at > ramp ? at : ramp) + ramp);
  if (steps < steps_) lay_out(shape, steps);
}

void MoveTimes::catch_up_with(const MoveTimes& original) {
  given_ = original.given_;
  last_ = original.last_;
  interval_ = original.interval_;
}

}  // namespace tetragauge
