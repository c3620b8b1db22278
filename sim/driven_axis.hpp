// SPDX-License-Identifier: GPL-3.0-or-later
// An axis behind a motor with play: turned back, the motor moves alone until it has taken the play up.
#pragma once

#include <algorithm>
#include <cstdint>

namespace tetragauge::sim {

class DrivenAxis {
 public:
  // Both at `start`, the play taken up going up.
  DrivenAxis(int32_t start_steps, int32_t backlash_steps)
      : motor_(start_steps), load_(start_steps), backlash_(backlash_steps) {}

  void step(bool up) {
    motor_ += up ? 1 : -1;
    load_ = std::clamp(load_, motor_, motor_ + backlash_);
  }
  // Where what it carries stands, in steps of the motor.
  int32_t load_steps() const { return load_; }

 private:
  int32_t motor_, load_, backlash_;
};

}  // namespace tetragauge::sim
