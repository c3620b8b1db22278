// SPDX-License-Identifier: Apache-2.0
// The mirrors' two voltages, by either of two converters behind one interface:
//
//   mirrors.begin(faults);
//   mirrors.set(a_code, b_code, faults);     // hal/board.hpp: both at once
//
// Which one a board has is chosen when its image is built (TETRAGAUGE_MIRRORS).
#pragma once

#include <cstdint>

#include "boards/stm32_h405/pins.hpp"
#include "boards/stm32_h405/registers/dac_spi.hpp"
#include "boards/stm32_h405/waits.hpp"
#include "firmware/hal/board.hpp"

namespace tetragauge {

// The chip's own, 12 bits: 0 to 3.3 V, 1.65 V in the middle; the wiring makes +-10 V of it. Their output
// amplifiers reach to 0.2 V from either supply (DS8626, DAC characteristics), from 3.0 V of it on.
template <class Bus>
class BuiltInMirrors {
 public:
  static constexpr int32_t kCodeStep = 16;
  static constexpr int32_t kReachUrad = 170'000;
  static_assert(int64_t{1'500} * kReachUrad / kUradPerMirrorCode / 32'768 <= 1'500 - 200, "mV of 3.0 V");

  void begin(WaitFaults& faults) {
    pins::MirrorA::analog<Bus>();
    pins::MirrorB::analog<Bus>();
    set(0, 0, faults);
    I::write(dac::kOn1(1) | dac::kOn2(1));
  }
  void set(int16_t a_code, int16_t b_code, WaitFaults&) {
    I::write(dac::kOut1(code12(a_code)) | dac::kOut2(code12(b_code)));
  }

 private:
  using I = Io<Bus>;
  static constexpr uint32_t code12(int32_t code) {
    const int32_t nearest = (code + 32'768 + kCodeStep / 2) / kCodeStep;
    return static_cast<uint32_t>(nearest > 4'095 ? 4'095 : nearest);
  }
};

// An Analog Devices AD5754R on SPI2, 16 bits, +-10 V by itself; outputs A and B. Its data sheet (rev. F),
// tables 17 to 25: 24 bits a word, taken at SCLK's falling edge: read/write, 0, register (3), address (3),
// data (16). BIN/2sCOMP is wired to ground: two's complement. LDAC low moves both new values to the outputs.
template <class Bus>
class Ad5754rMirrors {
 public:
  static constexpr int32_t kCodeStep = 1;
  static constexpr int32_t kReachUrad = 32'767 * kUradPerMirrorCode;

  void begin(WaitFaults& faults) {
    pins::DacSelect::output<Bus>();
    pins::DacLoad::output<Bus>();
    pins::DacSelect::set<Bus>(true);
    pins::DacLoad::set<Bus>(true);
    pins::DacClock::alternate<Bus>(pins::kSpiFunction, 2, 0);
    pins::DacData::alternate<Bus>(pins::kSpiFunction, 2, 0);
    // 42 MHz / 2 = 21 MHz (30 at most), clock low at rest, data taken at its second edge.
    I::write(spi2::kMaster(1) | spi2::kSelectBySoftware(1) | spi2::kSelectHigh(1) | spi2::kSecondEdge(1) |
             spi2::kOn(1));
    send(kPower, 0, kBothAndReference, faults);
    send(kRange, kAllOutputs, kPlusMinus10V, faults);
    set(0, 0, faults);
  }
  void set(int16_t a_code, int16_t b_code, WaitFaults& faults) {
    send(kValue, 0, static_cast<uint16_t>(a_code), faults);
    send(kValue, 1, static_cast<uint16_t>(b_code), faults);
    pins::DacLoad::set<Bus>(false);
    hold();
    pins::DacLoad::set<Bus>(true);
  }

 private:
  using I = Io<Bus>;
  enum : uint32_t { kValue = 0, kRange = 1, kPower = 2 };
  static constexpr uint32_t kAllOutputs = 4, kPlusMinus10V = 4, kBothAndReference = 0x13;
  // 8 bits at 21 MHz take 64 cycles of the core.
  static constexpr uint32_t kTurns = 1'000;

  void send(uint32_t which, uint32_t address, uint32_t data, WaitFaults& faults) {
    pins::DacSelect::set<Bus>(false);
    const uint32_t word = (which << 19) | (address << 16) | data;
    for (int shift = 16; shift >= 0; shift -= 8) {
      faults.wait_for<Bus>(spi2::kRoom(1), kTurns, WaitFault::kMirrorConverter);
      I::write(spi2::Dr{}, (word >> shift) & 0xFF);
    }
    // 28.3.7: all is out when there is room and the line is not busy, in this order.
    faults.wait_for<Bus>(spi2::kRoom(1), kTurns, WaitFault::kMirrorConverter);
    faults.wait_for<Bus>(spi2::kBusy(0), kTurns, WaitFault::kMirrorConverter);
    pins::DacSelect::set<Bus>(true);
    hold();
  }

  // At least 100 ns, what SYNC must stay high and LDAC low (20 ns): a look at a register on a bus of 42 MHz
  // takes two of its cycles, 48 ns.
  static void hold() {
    for (int look = 0; look < 3; ++look) I::read(spi2::Sr{});
  }
};

}  // namespace tetragauge
