// SPDX-License-Identifier: Apache-2.0
// From the internal oscillator, on which the chip starts, to 168 MHz from the crystal.
// RM0090 7.2, 3.5.1, 5.1.3.
#pragma once

#include "boards/stm32_h405/clock_tree.hpp"
#include "boards/stm32_h405/registers/flash.hpp"
#include "boards/stm32_h405/registers/rcc.hpp"
#include "boards/stm32_h405/waits.hpp"

namespace tetragauge {

// The core runs at 16 MHz here and a look takes 5 cycles at least: 3,200 looks a millisecond.
inline constexpr uint32_t kCrystalTurns = 320'000;  // 100 ms; DS8626 table 31: 2 ms typically
inline constexpr uint32_t kPllTurns = 3'200;        // 1 ms; DS8626 table 36: 0.3 ms at most
inline constexpr uint32_t kSwitchTurns = 3'200;

template <class Bus>
void start_clocks(WaitFaults& faults) {
  using namespace clock_tree;
  using I = Io<Bus>;
  rcc::switch_on<Bus>(rcc::kPwrOn(1));
  I::modify(pwr::kVoltageScale1(1));
  I::modify(rcc::kHseOn(1));
  const bool crystal = faults.wait_for<Bus>(rcc::kHseReady(1), kCrystalTurns, WaitFault::kCrystal);
  // Without the crystal from the internal 16 MHz: 1 % off, but the host can be told.
  I::modify(rcc::kPllM(crystal ? kPllM : kPllM * 2) | rcc::kPllN(kPllN) | rcc::kPllP(kPllP / 2 - 1) |
            rcc::kPllFromHse(crystal) | rcc::kPllQ(kPllQ));
  I::modify(rcc::kPllOn(1));
  I::write(flash::kLatency(kFlashWaitStates) | flash::kPrefetchOn(1) | flash::kInstructionCacheOn(1) |
           flash::kDataCacheOn(1));
  const bool latency =
      faults.wait_for<Bus>(flash::kLatency(kFlashWaitStates), kSwitchTurns, WaitFault::kFlashLatency);
  I::modify(rcc::kAhbDivider(0) | rcc::kApb1Divider(5) | rcc::kApb2Divider(4));  // 7.3.3: / 1, / 4, / 2
  static_assert(kApb1Divider == 4 && kApb2Divider == 2);
  const bool pll = faults.wait_for<Bus>(rcc::kPllReady(1), kPllTurns, WaitFault::kPll);
  // At 168 MHz with too few wait states, or with no clock, the chip would stop.
  if (!latency || !pll) return;
  I::modify(rcc::kSwitch(rcc::kToPll));
  faults.wait_for<Bus>(rcc::kSwitched(rcc::kToPll), kSwitchTurns, WaitFault::kClockSwitch);
}

}  // namespace tetragauge
