// SPDX-License-Identifier: Apache-2.0
// A number that differs between starts: from the random number generator; without it, what a memory cell held
// that no start clears, counted on.
#pragma once

#include "boards/stm32_h405/registers/iwdg_rng.hpp"
#include "boards/stm32_h405/registers/rcc.hpp"
#include "boards/stm32_h405/waits.hpp"

namespace tetragauge {

// `kept` is never cleared.
template <class Bus>
uint32_t make_boot_id(uint32_t* kept, WaitFaults& faults) {
  using I = Io<Bus>;
  ++*kept;
  rcc::switch_on<Bus>(rcc::kRngOn(1));
  I::write(rng::kOn(1));
  // 40 cycles of 48 MHz a number (24.3); the first is left (24.3.1: each must differ from the one before).
  for (int number = 0; number < 2; ++number) {
    if (!faults.wait_for<Bus>(rng::kReady(1), 3'000, WaitFault::kRandom)) return *kept;
    const uint32_t random = I::read(rng::Dr{});
    if (number == 1) return random ^ *kept;
  }
  return *kept;
}

}  // namespace tetragauge
