// SPDX-License-Identifier: Apache-2.0
// The independent watchdog (RM0090 section 21.4) and the random number generator (24.4).
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::iwdg {

using Kr = Register<0x40003000>;  // 21.4.1
inline constexpr uint32_t kFeed = 0xAAAA, kUnlock = 0x5555, kStart = 0xCCCC;
using Pr = Register<0x40003004>;   // 21.4.2: LSI / (4 << value)
using Rlr = Register<0x40003008>;  // 21.4.3
using Sr = Register<0x4000300C>;   // 21.4.4
inline constexpr Field<Sr, 0, 2> kUpdating;

}  // namespace tetragauge::iwdg

namespace tetragauge::rng {

using Cr = Register<0x50060800>;  // 24.4.1
inline constexpr Field<Cr, 2> kOn;
using Sr = Register<0x50060804>;  // 24.4.2
inline constexpr Field<Sr, 0> kReady;
using Dr = Register<0x50060808>;  // 24.4.3

}  // namespace tetragauge::rng
