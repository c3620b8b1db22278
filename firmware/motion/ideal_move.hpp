// SPDX-License-Identifier: Apache-2.0
// For tests: the ideal move in long double, by another way than speed_ramp.cpp's. Speed as a function of time
// is written down, its peak found by bisection on the distance, and a step's time by bisection on the
// position from whichever end is nearer.
#pragma once

#include <algorithm>
#include <cmath>

#include "firmware/motion/speed_ramp.hpp"

namespace tetragauge {

class IdealMove {
 public:
  IdealMove(uint32_t steps, const AxisLimits& limits)
      : steps_(steps), a_(limits.acceleration), j_(limits.jerk), peak_(limits.speed) {
    if (2 * covered(ramp_s()) > steps) {
      long double low = 0, high = peak_;
      for (int i = 0; i < 200; ++i) {
        peak_ = (low + high) / 2;
        (2 * covered(ramp_s()) > steps ? high : low) = peak_;
      }
    }
  }

  // Time from rest to the peak.
  long double ramp_s() const {
    if (j_ == 0) return peak_ / a_;
    return peak_ * j_ >= a_ * a_ ? peak_ / a_ + a_ / j_ : 2 * std::sqrt(peak_ / j_);
  }

  long double step_time_s(uint32_t step) const {
    const long double ramp = covered(ramp_s());
    const long double total = 2 * ramp_s() + std::max(0.0L, (steps_ - 2 * ramp) / peak_);
    if (step <= ramp) return when(step);
    if (steps_ - step <= ramp) return total - when(steps_ - step);
    return ramp_s() + (step - ramp) / peak_;
  }

 private:
  // Steps covered `t` s after the start, within the ramp: the integral of the speed. The ramp is
  // point-symmetric about its middle (half its time, half its speed).
  long double covered(long double t) const {
    if (j_ == 0) return a_ * t * t / 2;
    const long double whole = ramp_s();
    if (t > whole / 2) return peak_ * (t - whole / 2) + covered(whole - t);
    const long double rise = std::min(a_ / j_, whole / 2);
    const long double u = std::min(t, rise), rest = t - u;
    return j_ * u * u * u / 6 + rest * (j_ * u * u / 2) + j_ * u * rest * rest / 2;
  }
  long double when(long double distance) const {
    long double low = 0, high = ramp_s();
    for (int i = 0; i < 80; ++i) {
      const long double middle = (low + high) / 2;
      (covered(middle) < distance ? low : high) = middle;
    }
    return (low + high) / 2;
  }

  long double steps_, a_, j_, peak_;
};

}  // namespace tetragauge
