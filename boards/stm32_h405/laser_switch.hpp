// SPDX-License-Identifier: Apache-2.0
// The laser has light only while its enable pin is high AND a monostable outside is kicked (docs/machine.md:
// it falls after 10 ms). So a processor that stops in any state stops the light.
#pragma once

#include "boards/cortex_m4/chip_bus.hpp"
#include "boards/stm32_h405/pins.hpp"

namespace tetragauge {

template <class Bus>
class LaserSwitch {
 public:
  // A main loop that has not turned for so long gets no more kicks.
  static constexpr uint32_t kLoopMs = 50;

  void begin() {
    pins::LaserOn::output<Bus>();
    pins::LaserKick::output<Bus>();
  }
  void set(bool on) {
    const Gate<Bus> gate;
    if (on != on_) level(on);  // on: the first kick
    on_ = on;
    pins::LaserOn::set<Bus>(on);
  }
  void loop_turned() { ms_left_ = kLoopMs; }
  // Every millisecond. The monostable starts again at each rising edge: every second one, so that the pin is
  // low for a millisecond before, which no gate is too slow to see.
  void on_tick() {
    const Gate<Bus> gate;
    const uint32_t left = ms_left_;
    if (left > 0) ms_left_ = left - 1;
    if (!on_) return;
    if (left == 0) {
      pins::LaserOn::set<Bus>(false);
    } else {
      level(!level_);
    }
  }

 private:
  void level(bool high) {
    level_ = high;
    pins::LaserKick::set<Bus>(high);
  }

  volatile bool on_ = false, level_ = false;
  volatile uint32_t ms_left_ = 0;
};

}  // namespace tetragauge
