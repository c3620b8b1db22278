// SPDX-License-Identifier: Apache-2.0
// Both cameras at once: TIM8 starts a sample every 10 us, ADC1 and ADC2 convert one electrode of camera 1 and
// the same one of camera 2 together, four times, and DMA puts each pair into the buffer as one word.
// RM0090 13.9.2, mode 2 of 13.8.1.
//
// TIM8 makes as many triggers as the burst has samples and stops itself (17.3.10, with its repetition
// counter): however late an interrupt is, no sequence is under way when the next burst begins, so that its
// first word is the first electrode.
#pragma once

#include "boards/cortex_m4/chip_bus.hpp"
#include "boards/stm32_h405/clock_tree.hpp"
#include "boards/stm32_h405/pins.hpp"
#include "boards/stm32_h405/registers/adc.hpp"
#include "boards/stm32_h405/registers/dma.hpp"
#include "boards/stm32_h405/registers/timer.hpp"
#include "boards/stm32_h405/waits.hpp"
#include "firmware/hal/board.hpp"

namespace tetragauge {

// A sample as DMA leaves it, camera 2 in the upper half of each word, into the order of PsdSample, in place.
// 12 bits without sign become 15: full scale is full scale, dark is 0.
inline void sort_samples(PsdSample* samples, uint32_t count) {
  static_assert(sizeof(PsdSample) == 4 * clock_tree::kPairs);
  for (uint32_t i = 0; i < count; ++i) {
    auto* const cells = reinterpret_cast<int16_t*>(samples + i);
    int16_t sorted[2][clock_tree::kPairs];
    for (uint32_t pair = 0; pair < clock_tree::kPairs; ++pair) {
      for (uint32_t c = 0; c < 2; ++c) sorted[c][pair] = static_cast<int16_t>(cells[2 * pair + c] << 3);
    }
    for (uint32_t c = 0; c < 2; ++c)
      samples[i].camera[c] = {sorted[c][0], sorted[c][1], sorted[c][2], sorted[c][3]};
  }
}

template <class Bus>
class Sampler {
 public:
  void begin() {
    pins::Camera1X1::analog<Bus>();
    pins::Camera1X2::analog<Bus>();
    pins::Camera1Y1::analog<Bus>();
    pins::Camera1Y2::analog<Bus>();
    pins::Camera2X1::analog<Bus>();
    pins::Camera2X2::analog<Bus>();
    pins::Camera2Y1::analog<Bus>();
    pins::Camera2Y2::analog<Bus>();
    I::write(adc::kMulti(adc::kRegularSimultaneous) | adc::kPrescaler(adc::kBy4));
    begin<adc::Adc1>(10);
    begin<adc::Adc2>(6);
    I::modify(adc::Adc1::kTrigger(adc::kTim8TriggerOut) | adc::Adc1::kTriggerEdge(1));
    I::write(Tim8::Psc{}, 0);
    I::write(Tim8::Arr{}, clock_tree::kSampleTicks - 1);
    // So late in each period that the sample is there at its end.
    I::write(Trigger::Ccr{}, clock_tree::kSampleTicks - clock_tree::kConversionTicks);
    I::write(Trigger::kCompareMode(kHighFromMatch));
    I::write(Tim8::kTriggerOut(4));
  }

  void start(PsdSample* samples, uint32_t count, WaitFaults& faults) {
    Gate<Bus> gate;
    stop(faults);
    samples_ = samples;
    count_ = count;
    I::write(typename Into::Ifcr{}, Into::kAllFlags);
    I::write(typename Into::Par{}, adc::Cdr::kAddress);
    I::write(typename Into::M0ar{}, Bus::address_of(samples));
    I::write(typename Into::Ndtr{}, clock_tree::kPairs * count);
    I::write(Into::kPriority(3) | Into::kMemorySize(2) | Into::kPeripheralSize(2) |
             Into::kMemoryIncrement(1) | Into::kDoneInterrupt(1) | Into::kOn(1));  // channel 0
    I::modify(adc::kDmaMode(2));
    I::write(Tim8::Rcr{}, count - 1);
    I::write(Tim8::kUpdateNow(1));  // from 0, with that count
    I::write(Tim8::kOnePulse(1) | Tim8::kOn(1));
  }

  // The stream's. True when the burst is in the buffer.
  bool on_dma_interrupt(WaitFaults& faults) {
    const bool done = I::is(Into::kDone(1));
    stop(faults);
    I::write(typename Into::Ifcr{}, Into::kAllFlags);
    if (!done || samples_ == nullptr) return false;
    Bus::barrier();
    sort_samples(samples_, count_);
    samples_ = nullptr;
    return true;
  }

 private:
  using I = Io<Bus>;
  using Trigger = Tim8::Channel<1>;
  using Into = dma2::Stream<0>;  // channel 0: ADC1, and both in simultaneous mode

  template <class A>
  void begin(uint32_t first_input) {
    I::write(A::kScan(1));
    // 28 cycles (010) on the four inputs.
    uint32_t low = 0, high = 0, order = 0;
    for (uint32_t k = 0; k < clock_tree::kPairs; ++k) {
      const uint32_t input = first_input + k;
      (input < 10 ? low : high) |= 2u << (3 * (input % 10));
      order |= input << (5 * k);
    }
    I::write(typename A::Smpr2{}, low);
    I::write(typename A::Smpr1{}, high);
    I::write(typename A::Sqr3{}, order);
    I::write(A::kLength(clock_tree::kPairs - 1));
    I::write(A::kOn(1));
  }

  // No further triggers, requests or transfers, and no overrun left behind (13.8.1).
  void stop(WaitFaults& faults) {
    I::write(Tim8::kOnePulse(1) | Tim8::kOn(0));
    I::modify(adc::kDmaMode(0));
    I::modify(Into::kOn(0));
    // 10.3.17: the stream ends its transfer first, a few cycles.
    faults.wait_for<Bus>(Into::kOn(0), 1'000, WaitFault::kDmaStop);
    I::write(adc::Adc1::Sr{}, 0);
    I::write(adc::Adc2::Sr{}, 0);
  }

  PsdSample* samples_ = nullptr;
  uint32_t count_ = 0;
};

}  // namespace tetragauge
