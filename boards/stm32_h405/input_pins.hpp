// SPDX-License-Identifier: Apache-2.0
// Switches and ready signals. Each pin has a low-pass of its own (docs/machine.md: 1 kohm, 100 nF) and the
// chip's Schmitt trigger behind it; the interlock's edges pass TIM4's digital filter besides, and interrupt.
#pragma once

#include "boards/stm32_h405/pins.hpp"
#include "boards/stm32_h405/registers/timer.hpp"
#include "firmware/hal/board.hpp"

namespace tetragauge {

template <class Bus>
class InputPins {
 public:
  void begin() {
    pins::MirrorsGood::input<Bus>();
    pins::LaserGood::input<Bus>();
    pins::TableHome::input<Bus>();
    pins::SlideHome::input<Bus>();
    pins::SlideNotLow::input<Bus>();
    pins::SlideNotHigh::input<Bus>();
    pins::Interlock::alternate<Bus>(pins::kInterlockFunction, 0, 2);
    // Both edges, after 8 equal looks at 84 MHz / 4 / 32: 12 us (18.4.7, IC1F = 1111).
    I::write(Tim4::kFilterClockDivider(2));
    I::write(Edge::kSelection(1) | Edge::kInputFilter(15));
    I::write(Edge::kPinOn(1) | Edge::kFalling(1) | Edge::kBothEdges(1));
    I::write(Tim4::Sr{}, 0);
    I::write(Edge::kInterruptOn(1));
    I::modify(Tim4::kOn(1));
  }

  // Bits of Inputs (hal/board.hpp).
  uint32_t read() const {
    uint32_t bits = 0;
    if (pins::Interlock::high<Bus>()) bits |= Inputs::kInterlockClosed;
    if (pins::MirrorsGood::high<Bus>()) bits |= Inputs::kMirrorsGood;
    if (pins::LaserGood::high<Bus>()) bits |= Inputs::kLaserGood;
    if (pins::TableHome::high<Bus>()) bits |= Inputs::kTableHome;
    if (pins::SlideHome::high<Bus>()) bits |= Inputs::kSlideHome;
    if (!pins::SlideNotLow::high<Bus>()) bits |= Inputs::kSlideLimitLow;
    if (!pins::SlideNotHigh::high<Bus>()) bits |= Inputs::kSlideLimitHigh;
    return bits;
  }

  void on_interrupt() { I::write(Tim4::Sr{}, 0); }

 private:
  using I = Io<Bus>;
  using Edge = Tim4::Channel<1>;
};

}  // namespace tetragauge
