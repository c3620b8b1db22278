// SPDX-License-Identifier: Apache-2.0
// A 32-bit timer's count as one of 64 bits: the timer's interrupt counts its overflows.
#pragma once

#include <cstdint>

#include "boards/stm32_h405/registers/timer.hpp"

namespace tetragauge {

template <class Bus, class T>
class LongCount {
 public:
  // Counts on from 0, without end; its overflow interrupts.
  void begin() {
    I::write(typename T::Psc{}, 0);
    I::write(typename T::Arr{}, 0xFFFF'FFFF);
    I::write(typename T::Cr1{}, T::kUpdateByOverflowOnly(1).value);
    I::write(T::kUpdateNow(1));  // takes prescaler and limit over
    I::write(typename T::Sr{}, 0);
    I::write(T::kUpdateInterrupt(1));
    I::modify(T::kOn(1));
  }

  // From any priority: an overflow that its interrupt has not counted yet is seen by its flag.
  uint64_t now() const {
    for (;;) {
      const uint32_t high = high_;
      const uint32_t low = I::read(typename T::Cnt{});
      const bool pending = I::is(T::kUpdated(1));
      if (high != high_) continue;
      return (uint64_t{pending && low < 0x8000'0000 ? high + 1 : high} << 32) | low;
    }
  }

  void on_interrupt() {
    if (!I::is(T::kUpdated(1))) return;
    Gate<Bus> gate;  // nobody may see the flag cleared and the overflow not counted
    I::write(typename T::Sr{}, ~T::kUpdated.kMask);
    high_ = high_ + 1;
  }

 private:
  using I = Io<Bus>;
  volatile uint32_t high_ = 0;
};

}  // namespace tetragauge
