// SPDX-License-Identifier: Apache-2.0
// The two built-in converters (RM0090 section 14.5) and SPI2 (28.5) for an external one.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::dac {

using Cr = Register<0x40007400>;  // 14.5.1
inline constexpr Field<Cr, 0> kOn1;
inline constexpr Field<Cr, 16> kOn2;
using Dhr12Rd = Register<0x40007420>;  // 14.5.9: both at once, right-aligned
inline constexpr Field<Dhr12Rd, 0, 12> kOut1;
inline constexpr Field<Dhr12Rd, 16, 12> kOut2;

}  // namespace tetragauge::dac

namespace tetragauge::spi2 {

using Cr1 = Register<0x40003800>;            // 28.5.1
inline constexpr Field<Cr1, 0> kSecondEdge;  // CPHA
inline constexpr Field<Cr1, 2> kMaster;
inline constexpr Field<Cr1, 3, 3> kDivider;  // 0: / 2
inline constexpr Field<Cr1, 6> kOn;
inline constexpr Field<Cr1, 8> kSelectHigh;
inline constexpr Field<Cr1, 9> kSelectBySoftware;
using Sr = Register<0x40003808>;  // 28.5.3
inline constexpr Field<Sr, 1> kRoom;
inline constexpr Field<Sr, 7> kBusy;
using Dr = Register<0x4000380C>;  // 28.5.4

}  // namespace tetragauge::spi2
