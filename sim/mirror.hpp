// SPDX-License-Identifier: GPL-3.0-or-later
// One galvanometer mirror in closed loop: a second-order servo that follows a reference, which itself moves
// no faster than the driver's slew limit. So a small step settles in a fixed time and a large one takes
// longer by its ramp.
#pragma once

#include <cstdint>

namespace tetragauge::sim {

struct MirrorDynamics {
  double natural_rad_s = 0;
  double damping = 0;     // < 1
  double slew_rad_s = 0;  // of the reference
};

class Mirror {
 public:
  explicit Mirror(const MirrorDynamics& dynamics) : dynamics_(dynamics) {}

  // Calls come in order of time. A new target:
  void command(double target_rad, int64_t now_ns);
  // From now on it does not move, whatever it is told; then it follows again, towards its last target.
  void stick(int64_t now_ns);
  void release(int64_t now_ns);
  // Where the mirror is; once within 1e-8 rad (3 nm at the part) it stands exactly on its target.
  double angle_rad(int64_t now_ns) const;
  double rate_rad_s(int64_t now_ns) const;
  // How far off its target it is stuck; 0 for one that is not.
  double stuck_off_rad() const;

 private:
  struct State {
    double angle_rad = 0, rate_rad_s = 0;
  };
  State at(int64_t now_ns) const;
  double reference_rad(double t_s) const;

  MirrorDynamics dynamics_;
  bool stuck_ = false;
  int64_t commanded_ns_ = 0;
  State start_;  // at commanded_ns_
  double reference_start_rad_ = 0, target_rad_ = 0;
};

}  // namespace tetragauge::sim
