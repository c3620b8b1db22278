// SPDX-License-Identifier: Apache-2.0
// SysTick and TIM2 against each other: both come from the one PLL, over different dividers, so a wrong
// divider or a timer that does not run shows. TIM2's count is noted at every 32nd tick of a millisecond. An
// interrupt that is lost or late (flash at work, an emulator that has to wait for its host) spoils one
// stretch of 32; the best of the last eight counts.
#pragma once

#include <cstdint>

#include "boards/stm32_h405/clock_tree.hpp"

namespace tetragauge {

class ClockCheck {
 public:
  static constexpr uint32_t kTicks = 32, kStretches = 8;
  // An interrupt may be late by 20 us at either end.
  static constexpr int32_t kMostPpm = 1'250;

  // `count`: of TIM2.
  void on_tick(uint32_t count) {
    if (++ticks_ % kTicks != 0) return;
    if (ticks_ > kTicks) {
      constexpr int64_t kExpected = int64_t{clock_tree::kApb1TimerHz / 1000} * kTicks;
      const int64_t off = int64_t{count - before_} - kExpected;
      off_ppm_[measured_ % kStretches] = static_cast<int32_t>((off < 0 ? -off : off) * 1'000'000 / kExpected);
      measured_ = measured_ + 1;
    }
    before_ = count;
  }
  bool known() const { return measured_ > 0; }
  int32_t off_ppm() const {
    int32_t best = INT32_MAX;
    for (uint32_t k = 0; k < kStretches && k < measured_; ++k) {
      if (off_ppm_[k] < best) best = off_ppm_[k];
    }
    return best;
  }

 private:
  static_assert(0xFFFF'FFFFull * 1'000'000 / (clock_tree::kApb1TimerHz / 1000 * kTicks) <= INT32_MAX);
  uint32_t ticks_ = 0, before_ = 0;
  volatile uint32_t measured_ = 0;
  volatile int32_t off_ppm_[kStretches] = {};
};

}  // namespace tetragauge
