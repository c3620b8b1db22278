// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/mirror.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge::sim {
namespace {

constexpr double kAtRest_rad = 1e-8;

// x'' = w^2 (r - x) - 2 z w x' for r(t) = r0 + s t, solved in closed form: a particular solution that lags
// the ramp by 2 z s / w, and a damped oscillation that carries the rest.
void follow_ramp(const MirrorDynamics& d, double r0, double s, double t, double& x, double& v) {
  const double w = d.natural_rad_s, decay = d.damping * w;
  const double wd = w * std::sqrt(1 - d.damping * d.damping);
  const double lag = 2 * d.damping * s / w;
  const double h0 = x - (r0 - lag), h0_rate = v - s;
  const double a = h0, b = (h0_rate + decay * h0) / wd;
  const double e = std::exp(-decay * t), c = std::cos(wd * t), sn = std::sin(wd * t);
  x = r0 + s * t - lag + e * (a * c + b * sn);
  v = s + e * ((b * wd - decay * a) * c - (a * wd + decay * b) * sn);
}

}  // namespace

double Mirror::reference_rad(double t_s) const {
  const double way = target_rad_ - reference_start_rad_;
  const double done = std::min(dynamics_.slew_rad_s * t_s, std::abs(way));
  return reference_start_rad_ + std::copysign(done, way);
}

Mirror::State Mirror::at(int64_t now_ns) const {
  if (stuck_) return start_;
  const double t = static_cast<double>(now_ns - commanded_ns_) * 1e-9;
  const double way = target_rad_ - reference_start_rad_;
  const double ramp_s = std::abs(way) / dynamics_.slew_rad_s;
  State state = start_;
  const double on_ramp = std::min(t, ramp_s);
  follow_ramp(dynamics_, reference_start_rad_, std::copysign(dynamics_.slew_rad_s, way), on_ramp,
              state.angle_rad, state.rate_rad_s);
  if (t <= ramp_s) return state;
  // Longer than this no oscillation of any size we can start is left; it also keeps exp() from underflowing.
  const double settle_s = std::min(t - ramp_s, 60 / (dynamics_.damping * dynamics_.natural_rad_s));
  follow_ramp(dynamics_, target_rad_, 0, settle_s, state.angle_rad, state.rate_rad_s);
  const double rate_scale = dynamics_.natural_rad_s;
  if (std::abs(state.angle_rad - target_rad_) < kAtRest_rad &&
      std::abs(state.rate_rad_s) < kAtRest_rad * rate_scale) {
    return {target_rad_, 0};
  }
  return state;
}

void Mirror::command(double target_rad, int64_t now_ns) {
  const double reference = reference_rad(static_cast<double>(now_ns - commanded_ns_) * 1e-9);
  start_ = at(now_ns);
  reference_start_rad_ = reference;
  target_rad_ = target_rad;
  commanded_ns_ = now_ns;
}

void Mirror::stick(int64_t now_ns) {
  start_ = {at(now_ns).angle_rad, 0};
  stuck_ = true;
}

void Mirror::release(int64_t now_ns) {
  stuck_ = false;
  commanded_ns_ = now_ns;
  reference_start_rad_ = start_.angle_rad;
}

double Mirror::stuck_off_rad() const {
  return stuck_ ? std::abs(target_rad_ - start_.angle_rad) : 0;
}

double Mirror::angle_rad(int64_t now_ns) const {
  return at(now_ns).angle_rad;
}

double Mirror::rate_rad_s(int64_t now_ns) const {
  return at(now_ns).rate_rad_s;
}

}  // namespace tetragauge::sim
