// SPDX-License-Identifier: Apache-2.0
// Registers and their fields as types, so that a field cannot be written into another register:
//
//   using Cr = Register<0x40023800>;             // RCC_CR
//   inline constexpr Field<Cr, 16> kHseOn;       // one bit; Field<Cr, 6, 9> has nine
//   Io<Bus>::modify(kHseOn(1));                  // read, change, write
//   Io<Bus>::wait_for(kHseReady(1), 10'000);     // bounded; false: it never came
//
// Bus says how a register is reached: ChipBus by its address, a test's bus by writing it down.
#pragma once

#include <cstdint>

namespace tetragauge {

template <uint32_t kAt>
struct Register {
  static constexpr uint32_t kAddress = kAt;
};

// Some fields of one register with their values; | joins fields of the same one.
template <class R>
struct Bits {
  uint32_t mask = 0, value = 0;
  constexpr Bits operator|(Bits other) const { return {mask | other.mask, value | other.value}; }
};

template <class R, uint32_t kShift, uint32_t kWidth = 1>
struct Field {
  static_assert(kWidth > 0 && kShift + kWidth <= 32);
  static constexpr uint32_t kMask = (kWidth == 32 ? ~0u : (1u << (kWidth % 32)) - 1) << kShift;

  constexpr Bits<R> operator()(uint32_t value) const { return {kMask, (value << kShift) & kMask}; }
};

template <class Bus>
struct Io {
  // The whole register; what `bits` does not name becomes 0.
  template <class R>
  static void write(Bits<R> bits) {
    Bus::write(R::kAddress, bits.value);
  }
  template <class R>
  static void write(R, uint32_t value) {
    Bus::write(R::kAddress, value);
  }
  template <class R>
  static void modify(Bits<R> bits) {
    Bus::write(R::kAddress, (Bus::read(R::kAddress) & ~bits.mask) | bits.value);
  }
  template <class R>
  static uint32_t read(R) {
    return Bus::read(R::kAddress);
  }
  template <class R>
  static bool is(Bits<R> bits) {
    return (Bus::read(R::kAddress) & bits.mask) == bits.value;
  }
  // At most `turns` looks, each at least 5 cycles of the core (load, compare, branch).
  template <class R>
  static bool wait_for(Bits<R> bits, uint32_t turns) {
    for (uint32_t turn = 0; turn < turns; ++turn) {
      if (is(bits)) return true;
    }
    return false;
  }
};

}  // namespace tetragauge
