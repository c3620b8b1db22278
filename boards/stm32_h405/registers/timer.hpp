// SPDX-License-Identifier: Apache-2.0
// TIM2 to TIM5, RM0090 section 18.4, and what TIM8 (17.4) shares with them. TIM2 and TIM5 count 32 bits, the
// others 16.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge {

template <uint32_t kBase, uint32_t kNumber>
struct Timer {
  static constexpr uint32_t kInterrupt = kNumber;

  using Cr1 = Register<kBase + 0x00>;  // 18.4.1
  static constexpr Field<Cr1, 0> kOn{};
  static constexpr Field<Cr1, 2> kUpdateByOverflowOnly{};
  static constexpr Field<Cr1, 3> kOnePulse{};               // stops itself at an update
  static constexpr Field<Cr1, 8, 2> kFilterClockDivider{};  // 2: a quarter of the timer's clock
  using Cr2 = Register<kBase + 0x04>;                       // 18.4.2
  static constexpr Field<Cr2, 4, 3> kTriggerOut{};          // 4: with channel 1's output
  using Dier = Register<kBase + 0x0C>;                      // 18.4.4
  static constexpr Field<Dier, 0> kUpdateInterrupt{};
  using Sr = Register<kBase + 0x10>;  // 18.4.5; cleared by writing 0
  static constexpr Field<Sr, 0> kUpdated{};
  using Egr = Register<kBase + 0x14>;  // 18.4.6
  static constexpr Field<Egr, 0> kUpdateNow{};
  using Ccmr1 = Register<kBase + 0x18>;  // 18.4.7
  using Ccmr2 = Register<kBase + 0x1C>;  // 18.4.8
  using Ccer = Register<kBase + 0x20>;   // 18.4.9
  using Cnt = Register<kBase + 0x24>;
  using Psc = Register<kBase + 0x28>;
  using Arr = Register<kBase + 0x2C>;
  using Rcr = Register<kBase + 0x30>;  // 17.4.12, TIM8 alone: overflows to an update - 1

  // Channel 1 to 4.
  template <uint32_t kChannel>
  struct Channel {
    static_assert(kChannel >= 1 && kChannel <= 4);
    using Ccmr = Register<kBase + 0x18 + 4 * ((kChannel - 1) / 2)>;
    static constexpr uint32_t kHalf = 8 * ((kChannel - 1) % 2);
    static constexpr Field<Ccmr, kHalf, 2> kSelection{};        // 0 compare, 1 capture
    static constexpr Field<Ccmr, kHalf + 4, 3> kCompareMode{};  // the modes below
    static constexpr Field<Ccmr, kHalf + 4, 4> kInputFilter{};
    static constexpr Field<Ccer, 4 * (kChannel - 1)> kPinOn{};
    static constexpr Field<Ccer, 4 * (kChannel - 1) + 1> kFalling{};
    static constexpr Field<Ccer, 4 * (kChannel - 1) + 3> kBothEdges{};  // with kFalling
    static constexpr Field<Dier, kChannel> kInterruptOn{};
    static constexpr Field<Sr, kChannel> kMatched{};
    static constexpr Field<Egr, kChannel> kMatchNow{};
    using Ccr = Register<kBase + 0x34 + 4 * (kChannel - 1)>;
  };
};

// OCxM, 18.4.7
enum CompareMode : uint32_t {
  kNothing = 0,
  kActiveOnMatch = 1,
  kInactive = 4,
  kActive = 5,
  kHighFromMatch = 7,  // PWM mode 2
};

// 2.3, memory map; 12.2, table 62
using Tim2 = Timer<0x40000000, 28>;
using Tim4 = Timer<0x40000800, 30>;
using Tim5 = Timer<0x40000C00, 50>;
using Tim8 = Timer<0x40010400, 44>;  // its update's

}  // namespace tetragauge
