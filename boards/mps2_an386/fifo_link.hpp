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
    using I = Io<Bus>;
    I::write(timer0::Reload{}, ~0u);
    I::write(timer0::Value{}, ~0u);
    I::write(timer0::Ctrl{}, 1);
    last_ = ~0u;
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

  // Of the processor's time since begin(). To be asked at least once in 171 s of it.
  uint64_t ticks() {
    const uint32_t now = Io<Bus>::read(timer0::Value{});
    ticks_ += last_ - now;
    last_ = now;
    return ticks_;
  }

  [[noreturn]] static void fail(const char* why) {
    semihosting::say("tetragauge-mps2_an386: ");
    semihosting::say(why);
    semihosting::exit(false);
  }

 private:
  int32_t in_ = -1, out_ = -1;
  uint32_t last_ = 0;
  uint64_t ticks_ = 0;
};

}  // namespace tetragauge
