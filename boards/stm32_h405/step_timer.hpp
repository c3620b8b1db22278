// SPDX-License-Identifier: Apache-2.0
// Step pulses by TIM2's output compare: the pin rises at the tick asked for, whatever the processor does
// then. The interrupt of that edge, or the next schedule(), ends the pulse.
#pragma once

#include "boards/cortex_m4/chip_bus.hpp"
#include "boards/stm32_h405/long_count.hpp"
#include "boards/stm32_h405/pins.hpp"
#include "firmware/hal/board.hpp"

namespace tetragauge {

template <class Bus>
class StepTimer {
 public:
  // At least 1 us high: what an A4988 asks for; TMC2xxx and TMC5xxx are content with a tenth of it.
  static constexpr uint32_t kPulseTicks = 84;

  void begin() {
    pins::TableUp::output<Bus>();
    pins::SlideUp::output<Bus>();
    pins::MotorsOn::output<Bus>();
    // Held low before the pins are the timer's.
    I::write(Table::kCompareMode(kInactive) | Slide::kCompareMode(kInactive));
    I::write(Table::kPinOn(1) | Slide::kPinOn(1));
    count_.begin();
    pins::TableStep::alternate<Bus>(pins::kStepFunction, 1, 2);
    pins::SlideStep::alternate<Bus>(pins::kStepFunction, 1, 2);
    pins::MotorsOn::set<Bus>(true);
  }

  uint64_t now() const { return count_.now(); }

  // As Board::schedule_step (hal/board.hpp).
  bool schedule(Axis axis, uint64_t tick, int direction) {
    Gate<Bus> gate;  // both axes share registers
    return axis == Axis::kTable ? schedule<Table, pins::TableUp>(0, tick, direction)
                                : schedule<Slide, pins::SlideUp>(1, tick, direction);
  }

  bool cancel(Axis axis) {
    Gate<Bus> gate;
    return axis == Axis::kTable ? cancel<Table>(0) : cancel<Slide>(1);
  }

  // TIM2's. Calls on_step(axis) for each edge that has come.
  template <class OnStep>
  void on_interrupt(OnStep on_step) {
    count_.on_interrupt();
    if (take<Table>(0)) {
      on_step(Axis::kTable);
      end_pulse<Table>(0);
    }
    if (take<Slide>(1)) {
      on_step(Axis::kSlide);
      end_pulse<Slide>(1);
    }
  }

 private:
  using I = Io<Bus>;
  using Table = Tim2::Channel<3>;
  using Slide = Tim2::Channel<4>;

  // A pin that an edge has left high. Its interrupt was at this priority or above, so nothing comes between.
  template <class C>
  void end_pulse(int k) {
    if (!high_[k]) return;
    // Most often it has gone far enough already. A look takes 5 cycles of the core at least, which is 2.5
    // ticks.
    for (uint32_t look = 0; look < kPulseTicks && I::read(Tim2::Cnt{}) - edge_[k] < kPulseTicks; ++look) {
    }
    const Gate<Bus> gate;
    I::modify(C::kCompareMode(kInactive));
    high_[k] = false;
  }

  template <class C, class Up>
  bool schedule(int k, uint64_t tick, int direction) {
    end_pulse<C>(k);
    if (direction != 0) Up::template set<Bus>(direction > 0);
    drives_[k] = direction != 0;
    edge_[k] = static_cast<uint32_t>(tick);
    I::write(typename C::Ccr{}, edge_[k]);
    I::write(Tim2::Sr{}, ~C::kMatched.kMask);
    I::modify(C::kCompareMode(drives_[k] ? kActiveOnMatch : kInactive));
    I::modify(C::kInterruptOn(1));
    if (static_cast<int64_t>(tick - now()) > 0 || I::is(C::kMatched(1))) return true;
    // It has passed before it was written: at once.
    edge_[k] = I::read(Tim2::Cnt{});
    if (drives_[k]) I::modify(C::kCompareMode(kActive));
    I::write(C::kMatchNow(1));
    return false;
  }

  template <class C>
  bool cancel(int k) {
    if (drives_[k]) I::modify(C::kCompareMode(kNothing));  // a pin that is high stays high
    if (I::is(C::kMatched(1)) && I::is(C::kInterruptOn(1))) return false;
    I::modify(C::kInterruptOn(0));
    I::modify(C::kCompareMode(kInactive));
    drives_[k] = false;
    return true;
  }

  template <class C>
  bool take(int k) {
    if (!I::is(C::kMatched(1)) || !I::is(C::kInterruptOn(1))) return false;
    const Gate<Bus> gate;
    I::write(Tim2::Sr{}, ~C::kMatched.kMask);
    I::modify(C::kInterruptOn(0));
    high_[k] = drives_[k];
    return true;
  }

  LongCount<Bus, Tim2> count_;
  volatile bool drives_[kAxes] = {}, high_[kAxes] = {};
  volatile uint32_t edge_[kAxes] = {};
};

}  // namespace tetragauge
