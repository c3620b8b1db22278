// SPDX-License-Identifier: Apache-2.0
// What may fail to come ready, by name. Every wait is bounded; one that ends without is kept here, told to
// the host as a log line and by the number of flashes of the board's light, and keeps the laser off where
// measuring could be wrong.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge {

enum class WaitFault : uint8_t {
  kCrystal,          // RCC_CR.HSERDY
  kPll,              // RCC_CR.PLLRDY
  kFlashLatency,     // FLASH_ACR.LATENCY
  kClockSwitch,      // RCC_CFGR.SWS
  kDma,              // DMA2 copies nothing
  kDmaStop,          // DMA2 stream's EN stays 1
  kRandom,           // RNG_SR.DRDY
  kWatchdog,         // IWDG_SR
  kMirrorConverter,  // SPI2_SR
  kFlashBusy,        // FLASH_SR.BSY
};
inline constexpr uint32_t kWaitFaults = 10;

constexpr const char* name_of(WaitFault fault) {
  constexpr const char* kNames[kWaitFaults] = {
      "RCC_CR.HSERDY never came: the crystal does not run, the internal oscillator is in use",
      "RCC_CR.PLLRDY never came: no clock from the PLL",
      "FLASH_ACR.LATENCY does not hold what was written",
      "RCC_CFGR.SWS does not follow: the clock is not the PLL's",
      "DMA2 copies nothing: the serial line runs on interrupts, the converters give no samples",
      "DMA2: a stream does not stop",
      "RNG_SR.DRDY never came: the boot id is a count",
      "IWDG_SR never cleared: the watchdog's time is not the one asked for",
      "SPI2_SR: the mirror converter's line does not finish",
      "FLASH_SR.BSY never cleared: the store is out of use",
  };
  return kNames[static_cast<uint32_t>(fault)];
}

class WaitFaults {
 public:
  void add(WaitFault fault) { bits_ |= 1u << static_cast<uint32_t>(fault); }
  bool has(WaitFault fault) const { return (bits_ >> static_cast<uint32_t>(fault)) & 1; }
  bool any() const { return bits_ != 0; }
  uint32_t bits() const { return bits_; }
  // With one of these, times and voltages are not what they should be.
  bool measuring_is_off() const {
    return has(WaitFault::kCrystal) || has(WaitFault::kPll) || has(WaitFault::kFlashLatency) ||
           has(WaitFault::kClockSwitch) || has(WaitFault::kDma) || has(WaitFault::kMirrorConverter);
  }

  // False, and the fault kept, when it does not come within `turns` looks.
  template <class Bus, class R>
  bool wait_for(Bits<R> bits, uint32_t turns, WaitFault fault) {
    if (Io<Bus>::wait_for(bits, turns)) return true;
    add(fault);
    return false;
  }

 private:
  uint32_t bits_ = 0;
};

}  // namespace tetragauge
