// SPDX-License-Identifier: Apache-2.0
// The image's end of the bus. Without the world there is nothing to do: it says so and ends the emulator.
#pragma once

#include "boards/cortex_m4/register.hpp"
#include "boards/cortex_m4/semihosting.hpp"
#include "boards/mps2_an386/bus.hpp"

namespace tetragauge {

// CMSDK APB timer 0 (Arm DAI 0386, DDI 0479): counts down at 25 MHz.
namespace timer0 {
using Ctrl = Register<0x40000000>;
using Value = Register<0x40000004>;
using Reload = Register<0x40000008>;
}  // namespace timer0

template <class Bus>
class FifoLink {
 public:
  void begin() {
    Io<Bus>::write(timer0::Reload{}, ~0u);
    Io<Bus>::write(timer0::Ctrl{}, 1);
    in_ = semihosting::open(mps2_bus::kToImage, semihosting::Mode::read);
    out_ = semihosting::open(mps2_bus::kToWorld, semihosting::Mode::write);
    if (in_ < 0 || out_ < 0)
      fail("the FIFOs to_image and to_world are not there; tetragauge-emulator starts this image\n");
  }

  void receive(void* to, size_t bytes) {
    auto* at = static_cast<uint8_t*>(to);
    while (bytes > 0) {
      const size_t count = semihosting::read(in_, at, bytes);
      if (count == 0) semihosting::exit(true);  // the world has ended, and this with it
      at += count;
      bytes -= count;
    }
  }
  void send(const void* from, size_t bytes) {
    if (!semihosting::write(out_, from, bytes)) semihosting::exit(true);
  }

  // The processor's time since the last start_ticks(), at most 171 s.
  void start_ticks() { Io<Bus>::write(timer0::Value{}, ~0u); }
  uint32_t ticks() const { return ~0u - Io<Bus>::read(timer0::Value{}); }

  [[noreturn]] static void fail(const char* why) {
    semihosting::say("tetragauge-mps2_an386: ");
    semihosting::say(why);
    semihosting::exit(false);
  }

 private:
  int32_t in_ = -1, out_ = -1;
};

}  // namespace tetragauge
