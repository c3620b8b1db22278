// SPDX-License-Identifier: Apache-2.0
// The processor's own registers, the same on every Cortex-M4F. Armv7-M Architecture Reference Manual (DDI
// 0403E), chapter B3.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::core {

// SysTick, B3.3
using SystCsr = Register<0xE000E010>;
inline constexpr Field<SystCsr, 0> kSystEnable;
inline constexpr Field<SystCsr, 1> kSystTickInt;
inline constexpr Field<SystCsr, 2> kSystClkSource;  // 1: the processor's clock
using SystRvr = Register<0xE000E014>;
using SystCvr = Register<0xE000E018>;

// System control block, B3.2
using Vtor = Register<0xE000ED08>;
using Aircr = Register<0xE000ED0C>;
inline constexpr uint32_t kAircrKey = 0x05FA;
inline constexpr Field<Aircr, 2> kSysResetReq;
inline constexpr Field<Aircr, 16, 16> kVectKey;
using Shpr3 = Register<0xE000ED20>;
inline constexpr Field<Shpr3, 24, 8> kPriSysTick;

// Interrupt `number`, B3.4. The priority is the upper 4 bits of a byte here; a smaller number goes first.
template <uint32_t kNumber>
struct Interrupt {
  using Iser = Register<0xE000E100 + 4 * (kNumber / 32)>;
  static constexpr Field<Iser, kNumber % 32> kEnable{};
  using Ispr = Register<0xE000E200 + 4 * (kNumber / 32)>;
  static constexpr Field<Ispr, kNumber % 32> kPend{};
  using Ipr = Register<0xE000E400 + 4 * (kNumber / 4)>;
  static constexpr Field<Ipr, 8 * (kNumber % 4), 8> kPriority{};
};

template <class Bus, uint32_t kNumber>
void enable_interrupt(uint32_t priority) {
  Io<Bus>::modify(Interrupt<kNumber>::kPriority(priority << 4));
  Io<Bus>::write(Interrupt<kNumber>::kEnable(1));
}

// By the program itself: its handler has run when this returns, unless it is held back.
template <class Bus, uint32_t kNumber>
void pend_interrupt() {
  Io<Bus>::write(Interrupt<kNumber>::kPend(1));
  Bus::barrier();
}

// `every` cycles of the core, at most 2^24.
template <class Bus>
void start_systick(uint32_t every, uint32_t priority) {
  Io<Bus>::modify(kPriSysTick(priority << 4));
  Io<Bus>::write(SystRvr{}, every - 1);
  Io<Bus>::write(SystCvr{}, 0);
  Io<Bus>::write(kSystClkSource(1) | kSystTickInt(1) | kSystEnable(1));
}

}  // namespace tetragauge::core
