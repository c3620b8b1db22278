// SPDX-License-Identifier: Apache-2.0
// General-purpose pins. RM0090 section 8.4.
#pragma once

#include "boards/cortex_m4/register.hpp"

namespace tetragauge::gpio {

enum class PortName : uint32_t { kA = 0, kB = 1, kC = 2, kD = 3 };

template <PortName kPort>
struct Port {
  static constexpr uint32_t kBase = 0x40020000 + 0x400 * static_cast<uint32_t>(kPort);
  using Moder = Register<kBase + 0x00>;    // 8.4.1: 0 in, 1 out, 2 alternate, 3 analog
  using OtypeR = Register<kBase + 0x04>;   // 8.4.2
  using OspeedR = Register<kBase + 0x08>;  // 8.4.3: 0 slow .. 3 fast
  using PupdR = Register<kBase + 0x0C>;    // 8.4.4: 1 up, 2 down
  using Idr = Register<kBase + 0x10>;      // 8.4.5
  using Bsrr = Register<kBase + 0x18>;     // 8.4.7: low half sets, high half clears
  using Afrl = Register<kBase + 0x20>;     // 8.4.9
  using Afrh = Register<kBase + 0x24>;     // 8.4.10
};

// One pin and what it can be told: Pin<PortName::kA, 9>.
template <PortName kPort, uint32_t kNumber>
struct Pin {
  static_assert(kNumber < 16);
  using P = Port<kPort>;
  static constexpr Field<typename P::Moder, 2 * kNumber, 2> kMode{};
  static constexpr Field<typename P::OspeedR, 2 * kNumber, 2> kSpeed{};
  static constexpr Field<typename P::PupdR, 2 * kNumber, 2> kPull{};
  static constexpr Field<typename P::Idr, kNumber> kIn{};
  static constexpr Field<typename P::Bsrr, kNumber> kSet{};
  static constexpr Field<typename P::Bsrr, kNumber + 16> kClear{};

  template <class Bus>
  static void analog() {
    Io<Bus>::modify(kMode(3));
  }
  // Pulled down: a broken wire reads as 0.
  template <class Bus>
  static void input() {
    Io<Bus>::modify(kPull(2));
    Io<Bus>::modify(kMode(0));
  }
  // Low before it is driven.
  template <class Bus>
  static void output() {
    Io<Bus>::write(kClear(1));
    Io<Bus>::modify(kMode(1));
  }
  // DS8626 table 9 has the functions' numbers.
  template <class Bus>
  static void alternate(uint32_t function, uint32_t speed, uint32_t pull) {
    if constexpr (kNumber < 8) {
      Io<Bus>::modify(Field<typename P::Afrl, 4 * (kNumber % 8), 4>{}(function));
    } else {
      Io<Bus>::modify(Field<typename P::Afrh, 4 * (kNumber % 8), 4>{}(function));
    }
    Io<Bus>::modify(kSpeed(speed));
    Io<Bus>::modify(kPull(pull));
    Io<Bus>::modify(kMode(2));
  }
  template <class Bus>
  static void set(bool high) {
    if (high) {
      Io<Bus>::write(kSet(1));
    } else {
      Io<Bus>::write(kClear(1));
    }
  }
  template <class Bus>
  static bool high() {
    return Io<Bus>::is(kIn(1));
  }
};

}  // namespace tetragauge::gpio
