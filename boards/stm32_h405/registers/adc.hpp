// SPDX-License-Identifier: Apache-2.0
// ADC1 and ADC2. RM0090 section 13.13.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::adc {

template <uint32_t kBase>
struct Converter {
  using Sr = Register<kBase + 0x00>;   // 13.13.1; cleared by writing 0
  using Cr1 = Register<kBase + 0x04>;  // 13.13.2
  static constexpr Field<Cr1, 8> kScan{};
  using Cr2 = Register<kBase + 0x08>;  // 13.13.3
  static constexpr Field<Cr2, 0> kOn{};
  static constexpr Field<Cr2, 24, 4> kTrigger{};
  static constexpr Field<Cr2, 28, 2> kTriggerEdge{};  // 1: rising
  using Smpr1 = Register<kBase + 0x0C>;               // 13.13.4: channels 10 to 18, 3 bits each
  using Smpr2 = Register<kBase + 0x10>;               // 13.13.5: channels 0 to 9
  using Sqr1 = Register<kBase + 0x2C>;                // 13.13.9
  static constexpr Field<Sqr1, 20, 4> kLength{};      // conversions in the sequence - 1
  using Sqr3 = Register<kBase + 0x34>;                // 13.13.11: first to sixth conversion, 5 bits each
};
using Adc1 = Converter<0x40012000>;
using Adc2 = Converter<0x40012100>;

inline constexpr uint32_t kTim8TriggerOut = 14;  // 13.6, table 69

using Ccr = Register<0x40012304>;  // 13.13.16
inline constexpr Field<Ccr, 0, 5> kMulti;
inline constexpr uint32_t kRegularSimultaneous = 6;
inline constexpr Field<Ccr, 13> kDmaGoesOn;
inline constexpr Field<Ccr, 14, 2> kDmaMode;  // 2: both results in a word
inline constexpr Field<Ccr, 16, 2> kPrescaler;
inline constexpr uint32_t kBy4 = 1;
using Cdr = Register<0x40012308>;  // 13.13.17: ADC2 in the upper half

}  // namespace tetragauge::adc
