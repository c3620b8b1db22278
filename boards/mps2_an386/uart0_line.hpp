// SPDX-License-Identifier: Apache-2.0
// The board's UART0 as a line to the host, which QEMU's `-serial` puts on a socket. CMSDK APB UART (Arm DDI
// 0479, 4.3; Arm DAI 0386, table 3-5). QEMU gives a byte at a time and waits for it to be taken, so polling
// loses none.
#pragma once

#include <cstddef>
#include <cstdint>

#include "boards/cortex_m4/register.hpp"

namespace tetragauge {

namespace uart0 {
using Data = Register<0x40004000>;
using State = Register<0x40004004>;
inline constexpr Field<State, 0> kFull;      // no room for a byte on its way out
inline constexpr Field<State, 1> kReceived;  // a byte is there
using Ctrl = Register<0x40004008>;
inline constexpr Field<Ctrl, 0> kTransmitterOn;
inline constexpr Field<Ctrl, 1> kReceiverOn;
using BaudDivider = Register<0x40004010>;  // of 25 MHz, at least 16; QEMU sends nothing without
}  // namespace uart0

template <class Bus>
class Uart0Line {
 public:
  void begin() {
    I::write(uart0::BaudDivider{}, 25'000'000 / 921'600);
    I::write(uart0::kTransmitterOn(1) | uart0::kReceiverOn(1));
  }
  bool received() const { return I::is(uart0::kReceived(1)); }
  size_t read(uint8_t* bytes, size_t capacity) {
    size_t count = 0;
    while (count < capacity && received()) bytes[count++] = static_cast<uint8_t>(I::read(uart0::Data{}));
    return count;
  }
  size_t write(const uint8_t* bytes, size_t count) {
    size_t taken = 0;
    while (taken < count && !I::is(uart0::kFull(1))) I::write(uart0::Data{}, bytes[taken++]);
    return taken;
  }

 private:
  using I = Io<Bus>;
};

}  // namespace tetragauge
