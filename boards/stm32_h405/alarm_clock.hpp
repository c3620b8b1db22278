// SPDX-License-Identifier: Apache-2.0
// The board's time in nanoseconds and its one alarm, both of TIM5: a tick is 1000/84 ns.
#pragma once

#include "boards/cortex_m4/chip_bus.hpp"
#include "boards/stm32_h405/clock_tree.hpp"
#include "boards/stm32_h405/long_count.hpp"

namespace tetragauge {

template <class Bus>
class AlarmClock {
 public:
  void begin() { count_.begin(); }

  uint64_t now_ns() const { return count_.now() * kNsPerTicks / kTicksPerNs; }
  uint64_t ticks() const { return count_.now(); }

  void set_alarm_ns(uint64_t time_ns) {
    Gate<Bus> gate;
    // Rounded up: now_ns() at that tick is not before time_ns.
    due_ = (time_ns * kTicksPerNs + kNsPerTicks - 1) / kNsPerTicks;
    I::write(Alarm::Ccr{}, static_cast<uint32_t>(due_));
    I::write(Tim5::Sr{}, ~Alarm::kMatched.kMask);
    I::modify(Alarm::kInterruptOn(1));
    if (static_cast<int64_t>(due_ - count_.now()) <= 0 && !I::is(Alarm::kMatched(1))) {
      I::write(Alarm::kMatchNow(1));
    }
  }

  // TIM5's. True when the alarm's time has come; a match a turn of the counter (51 s) too early is none.
  bool on_interrupt() {
    count_.on_interrupt();
    if (!I::is(Alarm::kMatched(1)) || !I::is(Alarm::kInterruptOn(1))) return false;
    I::write(Tim5::Sr{}, ~Alarm::kMatched.kMask);
    if (count_.now() < due_) return false;
    I::modify(Alarm::kInterruptOn(0));
    return true;
  }

 private:
  using I = Io<Bus>;
  using Alarm = Tim5::Channel<1>;
  // 84 MHz: 21 ticks are 250 ns.
  static constexpr uint64_t kTicksPerNs = 21, kNsPerTicks = 250;
  static_assert(clock_tree::kApb1TimerHz * kNsPerTicks == kTicksPerNs * 1'000'000'000);

  LongCount<Bus, Tim5> count_;
  uint64_t due_ = 0;
};

}  // namespace tetragauge
