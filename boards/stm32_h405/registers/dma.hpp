// SPDX-License-Identifier: Apache-2.0
// DMA controller 2. RM0090 section 10.5; which stream and channel serves what: table 43.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::dma2 {

template <uint32_t kNumber>
struct Stream {
  static_assert(kNumber < 8);
  static constexpr uint32_t kBase = 0x40026400;
  // Flags of a stream, 10.5.1 to 10.5.4.
  static constexpr uint32_t kFlagShift = (kNumber % 4 % 2) * 6 + (kNumber % 4 / 2) * 16;
  using Isr = Register<kBase + (kNumber < 4 ? 0x00 : 0x04)>;
  using Ifcr = Register<kBase + (kNumber < 4 ? 0x08 : 0x0C)>;
  static constexpr Field<Isr, kFlagShift + 3> kFailed{};
  static constexpr Field<Isr, kFlagShift + 5> kDone{};
  static constexpr uint32_t kAllFlags = 0x3Du << kFlagShift;  // bit 1 is reserved

  static constexpr uint32_t kOf = kBase + 0x18 * kNumber;
  using Cr = Register<kOf + 0x10>;  // 10.5.5
  static constexpr Field<Cr, 0> kOn{};
  static constexpr Field<Cr, 4> kDoneInterrupt{};
  static constexpr Field<Cr, 6, 2> kDirection{};  // 0 from peripheral, 1 to it, 2 memory to memory
  static constexpr Field<Cr, 8> kCircular{};
  static constexpr Field<Cr, 9> kPeripheralIncrement{};
  static constexpr Field<Cr, 10> kMemoryIncrement{};
  static constexpr Field<Cr, 11, 2> kPeripheralSize{};  // 0 byte, 1 half-word, 2 word
  static constexpr Field<Cr, 13, 2> kMemorySize{};
  static constexpr Field<Cr, 16, 2> kPriority{};
  static constexpr Field<Cr, 25, 3> kChannel{};
  using Ndtr = Register<kOf + 0x14>;  // 10.5.6
  using Par = Register<kOf + 0x18>;   // 10.5.7
  using M0ar = Register<kOf + 0x1C>;  // 10.5.8
  using Fcr = Register<kOf + 0x24>;   // 10.5.10
  static constexpr Field<Fcr, 0, 2> kThreshold{};
  static constexpr Field<Fcr, 2> kNoDirectMode{};
};

// 12.2, table 62
constexpr uint32_t interrupt_of(uint32_t stream) {
  return stream < 5 ? 56 + stream : 68 + stream - 5;
}

}  // namespace tetragauge::dma2
