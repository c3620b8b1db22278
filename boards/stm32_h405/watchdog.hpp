// SPDX-License-Identifier: Apache-2.0
// The independent watchdog is fed only when all have checked in since the last time: the tick's interrupt,
// the main loop (whose controller does so only with its axes on time), and the line to the host.
#pragma once

#include <cstdint>

#include "boards/stm32_h405/clock_tree.hpp"
#include "boards/stm32_h405/registers/iwdg_rng.hpp"
#include "boards/stm32_h405/waits.hpp"

namespace tetragauge {

template <class Bus>
class Watchdog {
 public:
  // A transmitter that has bytes and sends none for so long hangs; a byte takes 11 us.
  static constexpr uint32_t kLineMs = 100;

  void begin(WaitFaults& faults) {
    I::write(iwdg::Kr{}, iwdg::kStart);
    I::write(iwdg::Kr{}, iwdg::kUnlock);
    static_assert(clock_tree::kWatchdogDivider == 4 << 4);
    I::write(iwdg::Pr{}, 4);
    I::write(iwdg::Rlr{}, clock_tree::kWatchdogTurns - 1);
    // Five cycles of the slow oscillator for each register (21.3.2): 600 us at 17 kHz; 168 MHz, 5 cycles a
    // look.
    faults.wait_for<Bus>(iwdg::kUpdating(0), 40'000, WaitFault::kWatchdog);
    I::write(iwdg::Kr{}, iwdg::kFeed);
  }

  // Every millisecond, from the interrupt: what the line has sent and what it has not.
  void on_tick(uint32_t sent, uint32_t waiting) {
    ticked_ = true;
    line_still_ms_ = waiting == 0 || sent != sent_before_ ? 0 : line_still_ms_ + 1;
    sent_before_ = sent;
  }
  void line_read() { line_read_ = true; }
  // From the main loop.
  void kick() {
    if (!ticked_ || !line_read_ || line_still_ms_ >= kLineMs) return;
    ticked_ = false;
    line_read_ = false;
    I::write(iwdg::Kr{}, iwdg::kFeed);
  }

 private:
  using I = Io<Bus>;
  volatile bool ticked_ = false, line_read_ = false;
  volatile uint32_t line_still_ms_ = 0;
  uint32_t sent_before_ = 0;
};

}  // namespace tetragauge
