// SPDX-License-Identifier: Apache-2.0
// USART1. RM0090 section 30.6.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::usart1 {

inline constexpr uint32_t kInterrupt = 37;  // 12.2, table 62

using Sr = Register<0x40011000>;  // 30.6.1
inline constexpr Field<Sr, 3> kOverrun;
inline constexpr Field<Sr, 4> kIdle;
inline constexpr Field<Sr, 5> kReceived;
inline constexpr Field<Sr, 7> kRoom;
using Dr = Register<0x40011004>;   // 30.6.2
using Brr = Register<0x40011008>;  // 30.6.3: divider * 16, with OVER8 = 0
using Cr1 = Register<0x4001100C>;  // 30.6.4
inline constexpr Field<Cr1, 2> kReceiverOn;
inline constexpr Field<Cr1, 3> kTransmitterOn;
inline constexpr Field<Cr1, 4> kIdleInterrupt;
inline constexpr Field<Cr1, 5> kReceivedInterrupt;
inline constexpr Field<Cr1, 7> kRoomInterrupt;
inline constexpr Field<Cr1, 13> kOn;
using Cr3 = Register<0x40011014>;  // 30.6.6
inline constexpr Field<Cr3, 6> kReceiveByDma;
inline constexpr Field<Cr3, 7> kTransmitByDma;

}  // namespace tetragauge::usart1
