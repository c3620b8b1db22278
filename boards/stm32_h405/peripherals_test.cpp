// SPDX-License-Identifier: Apache-2.0
// What the drivers do after their start: the line's rings, samples in order, the watchdog's check-ins, the
// laser's kicks, the store on a flash that behaves as RM0090 3.6 says, and what a start tells.
#include <gtest/gtest.h>

#include <cstring>
#include <deque>
#include <memory>

#include "boards/stm32_h405/boot_id.hpp"
#include "boards/stm32_h405/clock_check.hpp"
#include "boards/stm32_h405/flash_storage.hpp"
#include "boards/stm32_h405/input_pins.hpp"
#include "boards/stm32_h405/laser_switch.hpp"
#include "boards/stm32_h405/recorded_bus.hpp"
#include "boards/stm32_h405/reset_cause.hpp"
#include "boards/stm32_h405/sampler.hpp"
#include "boards/stm32_h405/serial_line.hpp"
#include "boards/stm32_h405/watchdog.hpp"
#include "firmware/storage/calibration_store.hpp"
#include "protocol/frame.hpp"

namespace tetragauge {
namespace {

using Bus = RecordedBus;

class Peripherals : public testing::Test {
 protected:
  void SetUp() override { Bus::reset(); }
  void TearDown() override { Bus::reset(); }
  WaitFaults faults;
};

// Bytes 0, 1, 2, ... in pieces of growing length, so that every place of the ring is a piece's end.
TEST_F(Peripherals, LineByDmaCarriesEveryByteBothWays) {
  auto line = std::make_unique<SerialLine<Bus>>();
  line->begin(91, true);
  auto* ring = static_cast<uint8_t*>(const_cast<void*>(const_cast<const volatile void*>(Bus::memory[0])));
  uint32_t came = 0;
  uint8_t next_in = 0, next_read = 0;
  for (uint32_t length = 1; length < 300; ++length) {
    for (uint32_t k = 0; k < length; ++k) ring[came++ % 1024] = next_in++;
    Bus::cells[0x40026444] = 1024 - came % 1024;  // DMA2_S2NDTR; reloaded at 0
    uint8_t bytes[64];
    size_t count = 0, all = 0;
    while ((count = line->read(bytes, sizeof bytes)) > 0) {
      for (size_t k = 0; k < count; ++k) ASSERT_EQ(bytes[k], next_read++);
      all += count;
    }
    ASSERT_EQ(all, length);
  }

  // The transmitter's stream takes a stretch each time it is started.
  std::deque<uint8_t> out;
  uint8_t next_out = 0;
  Bus::on_write = [&](uint32_t address, uint32_t value) {
    if (address != 0x400264B8 || !(value & 1)) return;  // DMA2_S7CR
    const uint32_t at = Bus::cells[0x400264C4], count = Bus::cells[0x400264BC];
    const auto* from = static_cast<const volatile uint8_t*>(Bus::memory[(at - 0x2000'0000) / 0x1'0000]);
    for (uint32_t k = 0; k < count; ++k) out.push_back(uint8_t{from[k]});
  };
  uint32_t sent = 0;
  for (uint32_t length = 1; length < 400; ++length) {
    std::vector<uint8_t> bytes(length);
    for (uint8_t& byte : bytes) byte = next_out++;
    size_t done = 0;
    while (done < length) {
      done += line->write(bytes.data() + done, length - done);
      if (length % 3 == 0) line->on_dma_interrupt();  // otherwise more waits
      if (done < length) line->on_dma_interrupt();
    }
    sent += length;
  }
  while (line->waiting() > 0) line->on_dma_interrupt();
  ASSERT_EQ(out.size(), sent);
  uint8_t expected = 0;
  for (const uint8_t byte : out) ASSERT_EQ(byte, expected++);
  EXPECT_EQ(line->sent(), sent);
}

TEST_F(Peripherals, LineByInterruptsCarriesEveryByteBothWays) {
  auto line = std::make_unique<SerialLine<Bus>>();
  line->begin(91, false);
  std::vector<uint8_t> out;
  uint32_t room = 1;
  Bus::on_write = [&](uint32_t address, uint32_t value) {
    if (address != 0x40011004) return;
    out.push_back(static_cast<uint8_t>(value));
    if (--room == 0) Bus::cells[0x40011000] &= ~0x80u;  // TXE
  };
  std::vector<uint8_t> bytes(1'500);
  for (size_t k = 0; k < bytes.size(); ++k) bytes[k] = static_cast<uint8_t>(k * 7);
  size_t done = 0;
  while (out.size() < bytes.size()) {
    done += line->write(bytes.data() + done, bytes.size() - done);
    room = 1;
    Bus::cells[0x40011000] |= 0x80;
    line->on_usart_interrupt();
  }
  EXPECT_EQ(out, bytes);
  EXPECT_EQ(Bus::cells[0x4001100C] & 0x80, 0u) << "TXEIE off when nothing is left";

  for (uint32_t k = 0; k < 100; ++k) {
    Bus::cells[0x40011000] |= 0x20;  // RXNE
    Bus::cells[0x40011004] = k;
    line->on_usart_interrupt();
    uint8_t byte = 0;
    ASSERT_EQ(line->read(&byte, 1), 1u);
    ASSERT_EQ(byte, k);
  }
}

TEST_F(Peripherals, SamplesComeIntoOrderAtFullScale) {
  PsdSample samples[2];
  const uint16_t raw[2][4][2] = {{{0, 4095}, {1, 2}, {3, 4}, {5, 6}},
                                 {{10, 20}, {30, 40}, {50, 60}, {70, 80}}};
  std::memcpy(samples, raw, sizeof raw);
  sort_samples(samples, 2);
  EXPECT_EQ(samples[0].camera[0].x1, 0);
  EXPECT_EQ(samples[0].camera[1].x1, 32'760);
  EXPECT_EQ(samples[0].camera[0].y2, 5 * 8);
  EXPECT_EQ(samples[1].camera[0].x2, 30 * 8);
  EXPECT_EQ(samples[1].camera[0].y1, 50 * 8);
  EXPECT_EQ(samples[1].camera[1].x2, 40 * 8);
}

TEST_F(Peripherals, ABurstIsDoneOnceAndOnlyWhenItsStreamSaysSo) {
  Sampler<Bus> sampler;
  sampler.begin();
  PsdSample samples[4] = {};
  sampler.start(samples, 4, faults);
  EXPECT_FALSE(sampler.on_dma_interrupt(faults)) << "an error of the stream is no burst";
  sampler.start(samples, 4, faults);
  Bus::cells[0x40026400] = 0x20;  // TCIF0
  EXPECT_TRUE(sampler.on_dma_interrupt(faults));
  EXPECT_FALSE(sampler.on_dma_interrupt(faults));
  EXPECT_EQ(Bus::cells[0x40010400] & 1, 0u) << "no more triggers";
  EXPECT_FALSE(faults.any());
}

size_t feeds() {
  size_t count = 0;
  for (const std::string& line : Bus::take_writes()) count += line == "IWDG_KR = 0000AAAA";
  return count;
}

TEST_F(Peripherals, TheWatchdogIsFedOnlyWhenAllHaveCheckedIn) {
  for (int who = 0; who < 8; ++who) {
    const bool interrupt = who & 1, line = who & 2, line_sends = who & 4;
    Bus::reset();
    Watchdog<Bus> watchdog;
    uint32_t sent = 0;
    size_t fed = 0;
    for (uint32_t ms = 0; ms < 500; ++ms) {
      if (line_sends) ++sent;
      if (interrupt) watchdog.on_tick(sent, 10);
      if (line) watchdog.line_read();
      watchdog.kick();
      if (ms >= Watchdog<Bus>::kLineMs) {
        fed += feeds();
      } else {
        Bus::take_writes();
      }
    }
    EXPECT_EQ(fed > 0, interrupt && line && line_sends) << who;
  }
}

TEST_F(Peripherals, ALineWithNothingToSendIsWell) {
  Watchdog<Bus> watchdog;
  for (uint32_t ms = 0; ms < 500; ++ms) {
    watchdog.on_tick(0, 0);
    watchdog.line_read();
    watchdog.kick();
  }
  EXPECT_EQ(feeds(), 500u);
}

// LaserOn is PB12, LaserKick PB14; set bits are the low half of BSRR. A kick is a rising edge.
struct LaserPins {
  bool on = false;
  bool kick = false;
  uint32_t kicks = 0;
  LaserPins() {
    Bus::on_write = [this](uint32_t address, uint32_t value) {
      if (address != 0x40020418) return;
      if (value & 1u << 12) on = true;
      if (value & 1u << 28) on = false;
      if (value & 1u << 14 && !kick) ++kicks;
      if (value & 1u << 14) kick = true;
      if (value & 1u << 30) kick = false;
    };
  }
};

TEST_F(Peripherals, TheLaserIsKickedOnlyWhileTheMainLoopTurns) {
  LaserPins pins;
  LaserSwitch<Bus> laser;
  laser.begin();
  laser.loop_turned();
  for (int ms = 0; ms < 10; ++ms) laser.on_tick();
  EXPECT_EQ(pins.kicks, 0u) << "never while it is off";
  laser.loop_turned();
  laser.set(true);
  EXPECT_TRUE(pins.on);
  EXPECT_EQ(pins.kicks, 1u) << "at once";
  laser.set(true);
  EXPECT_TRUE(pins.kick) << "told again, the kick is not cut short";
  // A whole millisecond high, a whole one low.
  for (uint32_t ms = 0; ms < LaserSwitch<Bus>::kLoopMs; ++ms) {
    laser.on_tick();
    EXPECT_EQ(pins.kick, ms % 2 == 1);
  }
  EXPECT_EQ(pins.kicks, 1 + LaserSwitch<Bus>::kLoopMs / 2);
  EXPECT_TRUE(pins.on);
  const uint32_t before = pins.kicks;
  for (int ms = 0; ms < 1'000; ++ms) laser.on_tick();
  EXPECT_EQ(pins.kicks, before) << "the main loop hangs";
  EXPECT_FALSE(pins.on);
  // Off and on again: an edge at once, whatever the pin was.
  for (const int ticks_on : {1, 2}) {
    laser.set(false);
    EXPECT_FALSE(pins.on || pins.kick);
    laser.loop_turned();
    const uint32_t kicks = pins.kicks;
    laser.set(true);
    EXPECT_EQ(pins.kicks, kicks + 1);
    for (int ms = 0; ms < ticks_on; ++ms) laser.on_tick();
  }
}

TEST_F(Peripherals, NothingPluggedInReadsAsUnsafe) {
  InputPins<Bus> inputs;
  inputs.begin();
  EXPECT_EQ(inputs.read(), Inputs::kSlideLimitLow | Inputs::kSlideLimitHigh);
  Bus::cells[0x40020410] = 1u << 6 | 1u << 7 | 1u << 8 | 1u << 9 | 1u << 5;
  Bus::cells[0x40020810] = 1u << 9 | 1u << 10;
  EXPECT_EQ(inputs.read(), Inputs::kInterlockClosed | Inputs::kMirrorsGood | Inputs::kLaserGood |
                               Inputs::kTableHome | Inputs::kSlideHome);
}

// Sectors 10 and 11: words, a lock with two keys, erasing by sector, programming that only clears bits.
class FlashModel {
 public:
  FlashModel() {
    for (auto& bank : words) bank.assign(FlashStorage<Bus>::kBankWords, 0);
    Bus::on_write = [this](uint32_t address, uint32_t value) { written(address, value); };
    Bus::on_read = [this](uint32_t address) {
      if (uint32_t* word = word_at(address)) Bus::cells[address] = *word;
      if (address == 0x40023C0C)
        Bus::cells[address] = errors | (busy_looks > 0 ? --busy_looks, 0x1'0000u : 0u);
    };
  }
  std::vector<uint32_t> words[2];
  uint32_t busy_looks = 0, errors = 0, erase_looks = 3;
  int64_t operations_left = INT64_MAX;  // then the power is gone

 private:
  uint32_t* word_at(uint32_t address) {
    if (address < 0x080C'0000 || address >= 0x0810'0000) return nullptr;
    return &words[(address - 0x080C'0000) / 0x2'0000][(address % 0x2'0000) / 4];
  }
  void written(uint32_t address, uint32_t value) {
    if (address == 0x40023C04) {
      keys = keys == 0 && value == 0x4567'0123 ? 1 : keys == 1 && value == 0xCDEF'89AB ? 2 : 0;
      if (keys == 2) control = 0;
    } else if (address == 0x40023C0C) {
      errors &= ~value;
    } else if (address == 0x40023C10 && keys == 2) {
      control = value;
      if (value & 0x8000'0000) keys = 0;
      const uint32_t sector = value >> 3 & 15;
      if ((value & 0x1'0002) == 0x1'0002 && sector >= 10 && operations_left-- > 0) {
        words[sector - 10].assign(FlashStorage<Bus>::kBankWords, 0xFFFF'FFFF);
        busy_looks = erase_looks;
      }
    } else if (uint32_t* word = word_at(address)) {
      if (keys == 2 && (control & 0x301) == 0x201) {
        if (operations_left-- > 0) *word &= value;
      } else {
        errors |= 0x80;  // PGSERR
      }
    }
  }
  int keys = 0;
  uint32_t control = 0x8000'0000;
};

tg_CalibrationCommit put_record(CalibrationStore* store, uint32_t bytes, uint8_t seed) {
  tg_CalibrationChunk chunk = tg_CalibrationChunk_init_zero;
  std::vector<uint8_t> record(bytes);
  for (size_t k = 0; k < bytes; ++k) record[k] = static_cast<uint8_t>(seed + 31 * k);
  chunk.total = bytes;
  chunk.crc = crc32c(record.data(), bytes);
  while (chunk.offset < bytes) {
    chunk.data.size = static_cast<pb_size_t>(std::min<size_t>(bytes - chunk.offset, sizeof chunk.data.bytes));
    std::memcpy(chunk.data.bytes, record.data() + chunk.offset, chunk.data.size);
    EXPECT_EQ(store->write(chunk), nullptr);
    chunk.offset += chunk.data.size;
  }
  return {bytes, chunk.crc};
}

void run(CalibrationStore* store, const tg_CalibrationCommit& commit) {
  ASSERT_EQ(store->commit_error(commit), nullptr);
  store->commit(commit);
  for (int turn = 0; store->busy(); ++turn) {
    ASSERT_LT(turn, 100'000);
    store->step();
  }
}

TEST_F(Peripherals, ThePowerMayGoAtAnyWordOfACalibration) {
  FlashModel flash;
  FlashStorage<Bus> storage(faults);
  CalibrationStore first(storage);
  first.find();
  run(&first, put_record(&first, 300, 1));
  ASSERT_EQ(first.outcome(), CalibrationStore::Outcome::kStored);
  const uint32_t old_crc = first.crc();
  const auto before = std::vector<std::vector<uint32_t>>{flash.words[0], flash.words[1]};

  bool whole = false;
  for (int64_t cut = 0; !whole; ++cut) {
    for (size_t bank = 0; bank < 2; ++bank) flash.words[bank] = before[bank];
    WaitFaults mine;
    FlashStorage<Bus> again(mine);
    CalibrationStore store(again);
    store.find();
    const tg_CalibrationCommit commit = put_record(&store, 280, 9);
    flash.operations_left = cut;
    run(&store, commit);
    whole = flash.operations_left > 0;
    flash.operations_left = INT64_MAX;
    FlashStorage<Bus> after_storage(mine);
    CalibrationStore after(after_storage);
    after.find();
    EXPECT_TRUE(after.crc() == old_crc || after.crc() == commit.crc) << "cut at operation " << cut;
    EXPECT_GT(after.total(), 0u);
    EXPECT_TRUE(!whole || after.crc() == commit.crc);
  }
}

TEST_F(Peripherals, AStoreThatStaysBusyIsNamedAndNotWaitedForForEver) {
  FlashModel flash;
  flash.erase_looks = UINT32_MAX;
  FlashStorage<Bus> storage(faults);
  ASSERT_TRUE(storage.erase(0));
  for (uint32_t look = 0; look < FlashStorage<Bus>::kBusyLooks - 1; ++look) ASSERT_TRUE(storage.busy());
  EXPECT_FALSE(storage.busy());
  EXPECT_TRUE(faults.has(WaitFault::kFlashBusy));
  EXPECT_FALSE(storage.erase(1));
}

TEST_F(Peripherals, AWriteThatFailsIsSaid) {
  FlashModel flash;
  FlashStorage<Bus> storage(faults);
  Bus::on_write = [&flash](uint32_t address, uint32_t) {
    if (address >= 0x080C'0000 && address < 0x0810'0000) flash.errors = 0x10;  // WRPERR
  };
  const uint32_t word = 1;
  EXPECT_FALSE(storage.write(0, 0, &word, 1));
  EXPECT_FALSE(storage.erase(0)) << "the last one has failed";
}

TEST_F(Peripherals, ResetCauses) {
  // RM0090 7.3.21; every reset sets the pin's flag, power-on the brown-out's too.
  const std::pair<uint32_t, tg_ResetCause> kCases[] = {
      {0x0E00'0000, tg_ResetCause_RESET_POWER},    {0x0400'0000, tg_ResetCause_RESET_PIN},
      {0x1400'0000, tg_ResetCause_RESET_SOFTWARE}, {0x2400'0000, tg_ResetCause_RESET_WATCHDOG},
      {0x4400'0000, tg_ResetCause_RESET_WATCHDOG}, {0x0000'0000, tg_ResetCause_RESET_UNKNOWN}};
  for (const auto& [flags, cause] : kCases) {
    Bus::reset();
    Bus::cells[0x40023874] = flags;
    EXPECT_EQ(take_reset_cause<Bus>(), cause);
    EXPECT_EQ(Bus::cells[0x40023874] & 0x0100'0000, 0x0100'0000u) << "RMVF";
  }
}

TEST_F(Peripherals, BootIdsDifferWithAndWithoutRandomNumbers) {
  uint32_t kept = 0x1234;
  const uint32_t one = make_boot_id<Bus>(&kept, faults), two = make_boot_id<Bus>(&kept, faults);
  EXPECT_NE(one, two);
  EXPECT_TRUE(faults.has(WaitFault::kRandom));
  Bus::cells[0x50060804] = 1;
  Bus::cells[0x50060808] = 0xCAFE'F00D;
  const uint32_t random = make_boot_id<Bus>(&kept, faults);
  EXPECT_EQ(random, 0xCAFE'F00Du ^ kept);
}

TEST_F(Peripherals, TheClockCheckSeesAWrongDividerAndForgivesALateInterrupt) {
  const auto off = [](double ticks_a_ms, uint32_t late_at) {
    ClockCheck check;
    for (uint32_t ms = 1; ms <= 1'000; ++ms)
      check.on_tick(static_cast<uint32_t>(ms * ticks_a_ms) + (ms == late_at ? 40'000 : 0));
    EXPECT_TRUE(check.known());
    return check.off_ppm();
  };
  EXPECT_EQ(off(84'000, 0), 0);
  EXPECT_EQ(off(84'000, 992), 0);
  EXPECT_EQ(off(42'000, 0), 500'000);
  EXPECT_EQ(off(0, 0), 1'000'000);
  EXPECT_NEAR(off(1'000'000, 0), 10'904'762, 2);
}

}  // namespace
}  // namespace tetragauge
