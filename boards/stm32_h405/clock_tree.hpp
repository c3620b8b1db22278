// SPDX-License-Identifier: Apache-2.0
// Every clock of the board as a constant, checked against the chip's limits when it is compiled. RM0090
// figure 21 has the tree; limits: DS8626 (STM32F405xx data sheet) tables 14, 36, 37, 67 and RM0090 7.3.2.
#pragma once

#include <cstdint>

namespace tetragauge::clock_tree {

inline constexpr uint32_t kCrystalHz = 8'000'000;  // on the STM32-H405
inline constexpr uint32_t kPllM = 8, kPllN = 336, kPllP = 2, kPllQ = 7;
inline constexpr uint32_t kApb1Divider = 4, kApb2Divider = 2;

inline constexpr uint32_t kPllInHz = kCrystalHz / kPllM;
inline constexpr uint32_t kPllHz = kPllInHz * kPllN;
inline constexpr uint32_t kCoreHz = kPllHz / kPllP;  // and AHB, memories, DMA
inline constexpr uint32_t kApb1Hz = kCoreHz / kApb1Divider;
inline constexpr uint32_t kApb2Hz = kCoreHz / kApb2Divider;
// Timers run at twice their bus where that is divided (7.2).
inline constexpr uint32_t kApb1TimerHz = 2 * kApb1Hz;  // TIM2 to TIM5
inline constexpr uint32_t kApb2TimerHz = 2 * kApb2Hz;  // TIM8
inline constexpr uint32_t kAdcHz = kApb2Hz / 4;
inline constexpr uint32_t kFlashWaitStates = 5;

static_assert(kCrystalHz % kPllM == 0 && kPllInHz >= 1'000'000 && kPllInHz <= 2'000'000);
static_assert(kPllN >= 50 && kPllN <= 432 && kPllHz >= 100'000'000 && kPllHz <= 432'000'000);
static_assert(kPllHz % kPllP == 0 && kCoreHz == 168'000'000, "scale 1 goes to 168 MHz");
static_assert(kPllHz / kPllQ == 48'000'000, "the random number generator's and USB's");
static_assert(kApb1Hz <= 42'000'000 && kApb2Hz <= 84'000'000);
static_assert(kAdcHz <= 36'000'000, "with the analog supply above 2.4 V");
static_assert(kCoreHz <= 30'000'000 * (kFlashWaitStates + 1), "RM0090 table 10, 2.7 to 3.6 V");

// USART1, 16 samples a bit (RM0090 30.3.4): the line may be off by 2 % on both sides together; a quarter of
// it here.
constexpr uint32_t usart_divider(uint32_t baud) {
  return (kApb2Hz + baud / 2) / baud;
}
constexpr uint32_t baud_error_ppm(uint32_t baud) {
  const int64_t made = kApb2Hz / usart_divider(baud);
  const int64_t off = (made - baud) * 1'000'000 / baud;
  return static_cast<uint32_t>(off < 0 ? -off : off);
}
inline constexpr uint32_t kBaud = 921'600, kFastBaud = 2'000'000;
static_assert(usart_divider(kBaud) == 91 && usart_divider(kFastBaud) == 42);
static_assert(usart_divider(kFastBaud) >= 16);
static_assert(baud_error_ppm(kBaud) <= 5'000 && baud_error_ppm(kFastBaud) <= 5'000);

// A sample: four pairs, one after the other, and 28 + 12 cycles of the converter's clock each (13.5).
inline constexpr uint32_t kSampleHz = 100'000;
inline constexpr uint32_t kPairs = 4, kPairCycles = 28 + 12;
inline constexpr uint32_t kSampleTicks = kApb2TimerHz / kSampleHz;  // TIM8's
inline constexpr uint32_t kConversionTicks = kPairs * kPairCycles * (kApb2TimerHz / kAdcHz);
static_assert(kApb2TimerHz % kSampleHz == 0 && kApb2TimerHz % kAdcHz == 0 && kSampleTicks <= 0x10000);
static_assert(kConversionTicks < kSampleTicks, "a sample ends before the next begins");

// Watchdog: the low-speed oscillator runs at 17 to 47 kHz, 32 nominally (DS8626 table 33). At its fastest the
// time must outlast the erasure of a sector of 128 KB, 2 s at most (DS8626 table 39), with half of it in
// reserve.
inline constexpr uint32_t kWatchdogDivider = 64, kWatchdogTurns = 2'400;
inline constexpr uint32_t kWatchdogShortestMs = kWatchdogTurns * kWatchdogDivider / 47;
inline constexpr uint32_t kWatchdogNominalMs = kWatchdogTurns * kWatchdogDivider / 32;
inline constexpr uint32_t kLongestEraseMs = 2'000;
static_assert(kWatchdogTurns <= 4'096);
static_assert(kWatchdogShortestMs >= kLongestEraseMs * 3 / 2);

}  // namespace tetragauge::clock_tree
