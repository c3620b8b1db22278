// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/speed_ramp.hpp"

namespace tetragauge {
namespace {

constexpr double kPositionUnit = 1099511627776.0;  // 2^40

// The upper half of the product, up to 2 too small: the partial product of the lower halves is left out.
uint64_t high_product(uint64_t x, uint64_t y) {
  const uint32_t xh = static_cast<uint32_t>(x >> 32), xl = static_cast<uint32_t>(x);
  const uint32_t yh = static_cast<uint32_t>(y >> 32), yl = static_cast<uint32_t>(y);
  return uint64_t{xh} * yh + ((uint64_t{xh} * yl) >> 32) + ((uint64_t{xl} * yh) >> 32);
}

uint64_t fixed(double x) {
  return static_cast<uint64_t>(x + 0.5);
}

}  // namespace

double nth_root(double x, int n) {
  if (!(x > 0)) return 0;
  const auto power = [n](double y) { return n == 2 ? y * y : y * y * y; };
  double y = 1;
  while (power(y) > x) y *= 0.5;
  while (power(y) < x) y *= 2;
  // From above Newton's method comes down without ever going below, but for rounding.
  for (;;) {
    const double next = y - (power(y) - x) / (n * (power(y) / y));
    if (!(next < y)) return y;
    y = next;
  }
}

double RampShape::speed() const {
  return jerk > 0 ? jerk * rise * (rise + constant) : acceleration * constant;
}
double RampShape::duration() const {
  return 2 * rise + constant;
}
// Speed over time is symmetric about the ramp's middle.
double RampShape::distance() const {
  return speed() * duration() / 2;
}

RampShape ramp_to_speed(const AxisLimits& limits) {
  const double v = limits.speed, a = limits.acceleration, j = limits.jerk;
  RampShape shape{a, j, 0, 0};
  if (limits.jerk == 0) {
    shape.constant = v / a;
  } else if (v * j >= a * a) {
    shape.rise = a / j;
    shape.constant = v / a - shape.rise;
  } else {
    shape.rise = nth_root(v / j, 2);
  }
  return shape;
}

RampShape ramp_over(double distance, const AxisLimits& limits) {
  const double a = limits.acceleration, j = limits.jerk;
  RampShape shape{a, j, 0, 0};
  if (limits.jerk == 0) {
    shape.constant = nth_root(2 * distance / a, 2);
    return shape;
  }
  // Distance of a ramp that just reaches full acceleration: a^3 / j^2.
  shape.rise = a / j;
  if (distance * j * j <= a * a * a) {
    shape.rise = nth_root(distance / j, 3);
    return shape;
  }
  // v (v / a + a / j) = 2 distance, solved for v without cancellation.
  const double b = a * a / j;
  const double v = 4 * distance * a / (nth_root(b * b + 8 * distance * a, 2) + b);
  const double constant = v / a - shape.rise;
  shape.constant = constant > 0 ? constant : 0;
  return shape;
}

RampShape ramp_cut_at(double time, const RampShape& shape) {
  RampShape cut = shape;
  if (time >= shape.rise + shape.constant) return cut;
  if (time <= shape.rise) {
    cut.rise = time;
    cut.constant = 0;
  } else {
    cut.constant = time - shape.rise;
  }
  return cut;
}

void SpeedRamp::plan(const RampShape& shape, double fine_per_s) {
  at_ = 0;
  const double j = shape.jerk;
  const double a = j > 0 ? j * shape.rise : shape.acceleration;
  // Of each phase: when it begins, where, how fast, and how much it accelerates.
  const double v1 = j > 0 ? j * shape.rise * shape.rise / 2 : 0;
  const double v2 = v1 + a * shape.constant;
  const double s1 = v1 * shape.rise / 3;
  const double s2 = s1 + (v1 + v2) / 2 * shape.constant;
  const double t1 = shape.rise, t2 = t1 + shape.constant;
  const double begin[kPhases + 1] = {0, t1, t2, shape.duration()};
  const double from[kPhases + 1] = {0, s1, s2, shape.distance()};
  const double speed[kPhases] = {0, v1, v2};
  const double acceleration[kPhases] = {0, a, a};
  for (int i = 0; i < kPhases; ++i) {
    Phase& phase = phase_[i];
    phase.begin = fixed(begin[i] * fine_per_s);
    phase.end = fixed(begin[i + 1] * fine_per_s);
    phase.begin_position = fixed(from[i] * kPositionUnit);
    phase.end_position = fixed(from[i + 1] * kPositionUnit);
    phase.falling = i == 2;
    // 2^(64 - shift) fine units, X seconds, are just more than the phase takes.
    phase.shift = 1;
    while (phase.shift < 63 && (phase.end - phase.begin) < (uint64_t{1} << (63 - phase.shift))) ++phase.shift;
    const double x = static_cast<double>(uint64_t{1} << (64 - phase.shift)) / fine_per_s;
    phase.c1 = fixed(speed[i] * x * kPositionUnit);
    phase.c2 = fixed(acceleration[i] / 2 * x * x * kPositionUnit);
    phase.c3 = i == 1 ? 0 : fixed(j / 6 * x * x * x * kPositionUnit);
  }
}

uint64_t SpeedRamp::position(const Phase& phase, uint64_t time) {
  const uint64_t x = (time - phase.begin) << phase.shift;
  const uint64_t cubic = high_product(x, phase.c3);
  const uint64_t square = phase.falling ? phase.c2 - cubic : phase.c2 + cubic;
  return phase.begin_position + high_product(x, phase.c1 + high_product(x, square));
}

// Newton's method with the true slope. Speed never falls along the ramp, so position is convex and every step
// but the first comes from the right, without overshooting; a step out of the phase is cut at its ends.
uint64_t SpeedRamp::newton(const Phase& phase, uint64_t position_wanted, uint64_t time) {
  for (int iteration = 0; iteration < 64; ++iteration) {
    const int64_t missing = static_cast<int64_t>(position_wanted - position(phase, time));
    const uint64_t x = (time - phase.begin) << phase.shift;
    const uint64_t cubic = 3 * high_product(x, phase.c3);
    const uint64_t square = phase.falling ? 2 * phase.c2 - cubic : 2 * phase.c2 + cubic;
    const uint64_t slope = phase.c1 + high_product(x, square);
    uint64_t next = phase.end;  // at rest there is no slope: from the other end
    if (slope > 0) {
      const float unit = static_cast<float>(uint64_t{1} << (64 - phase.shift));
      const float change = static_cast<float>(missing) / static_cast<float>(slope) * unit;
      if (change <= -static_cast<float>(time - phase.begin)) {
        next = phase.begin;
      } else if (change < static_cast<float>(phase.end - time)) {
        next = time + static_cast<uint64_t>(static_cast<int64_t>(change));
      }
    }
    const uint64_t moved = next > time ? next - time : time - next;
    time = next;
    if (moved <= kFinePerTick / 16) break;
  }
  return time;
}

uint64_t SpeedRamp::time_at(uint32_t steps, uint64_t guess, uint64_t interval) {
  if (steps == 0) return 0;
  const uint64_t wanted = uint64_t{steps} << 40;
  while (at_ < kPhases - 1 && wanted > phase_[at_].end_position) ++at_;
  while (at_ > 0 && wanted <= phase_[at_].begin_position) --at_;
  const Phase& phase = phase_[at_];
  const uint64_t time = guess < phase.begin ? phase.begin : guess > phase.end ? phase.end : guess;
  const int64_t missing = static_cast<int64_t>(wanted - position(phase, time)) >> 8;
  // Within half a step: one step of the method, if what it leaves (up to three times its square over the
  // interval) is under a fifth of a tick.
  if (missing == static_cast<int32_t>(missing) && interval < (uint64_t{1} << 32)) {
    const int32_t change = static_cast<int32_t>((missing * static_cast<int64_t>(interval)) >> 32);
    const int64_t square = int64_t{change} * change;
    if (square < static_cast<int64_t>(interval * (kFinePerTick / 16))) {
      return time + static_cast<uint64_t>(int64_t{change});
    }
  }
  return newton(phase, wanted, time);
}

}  // namespace tetragauge
