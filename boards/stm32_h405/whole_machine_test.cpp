// SPDX-License-Identifier: Apache-2.0
// The whole firmware on this board's drivers, on a model of the chip that behaves as RM0090 says: clocks come
// ready, timers count and match, DMA moves what it is told to, and between pins and memory nothing else
// connects the two ends. What QEMU's STM32F405 lacks is exercised here: converters, output compare, DMA, the
// laser's pins.
#include <gtest/gtest.h>

#include <cstring>
#include <deque>
#include <memory>

#include "boards/stm32_h405/interrupts.hpp"
#include "boards/stm32_h405/recorded_bus.hpp"
#include "boards/stm32_h405/stm32_board.hpp"
#include "firmware/controller.hpp"
#include "firmware/test_views.hpp"
#include "protocol/message.hpp"

namespace tetragauge {
namespace {

using Bus = RecordedBus;
using TestedBoard = Stm32Board<Bus, BuiltInMirrors>;
using Firmware = Controller<TestedBoard>;
using OnInterrupt = Interrupts<TestedBoard, Firmware>;

constexpr uint32_t kTim2 = 0x40000000, kTim5 = 0x40000C00, kTim8 = 0x40010400;
constexpr uint64_t kNever = ~uint64_t{0};
constexpr uint64_t kTicksPerMs = 84'000;

class Chip {
 public:
  Chip() {
    Bus::reset();
    Bus::on_write = [this](uint32_t address, uint32_t value) { written(address, value); };
    Bus::on_read = [this](uint32_t address) { about_to_read(address); };
    Bus::cells[0x40023874] = 0x0E00'0000;  // power-on
  }
  ~Chip() { Bus::reset(); }

  // Wired to the pins.
  bool interlock_closed = true;
  int64_t table = 300, slide = 300;  // motors; home at and below 0
  bool laser_on = false;
  uint32_t laser_kicks = 0;
  uint32_t mirrors = 0;
  std::deque<uint8_t> line_out;
  uint32_t bursts = 0;

  uint64_t ticks = 0;  // of 84 MHz
  void line_in(const uint8_t* bytes, size_t count) {
    auto* ring = static_cast<volatile uint8_t*>(memory(Bus::cells[0x4002644C]));
    uint32_t& left = Bus::cells[0x40026444];  // DMA2_S2NDTR
    for (size_t k = 0; k < count; ++k) {
      ring[1024 - left] = bytes[k];
      left = left == 1 ? 1024 : left - 1;
    }
  }

  uint64_t next_event() const {
    uint64_t next = (ticks / kTicksPerMs + 1) * kTicksPerMs;
    for (const Counter* counter : {&steps_, &clock_}) {
      for (int channel = 1; channel <= 4; ++channel) {
        const uint32_t in = counter->ccr(channel) - static_cast<uint32_t>(ticks);
        if (counter->enabled() >> channel & 1) next = std::min(next, ticks + (in == 0 ? 0x1'0000'0000u : in));
      }
    }
    return std::min({next, burst_end_, sent_at_});
  }
  // The clock goes on; what is due happens.
  void advance_to(uint64_t to) {
    for (Counter* counter : {&steps_, &clock_}) {
      for (int channel = 1; channel <= 4; ++channel) {
        const uint64_t in = counter->ccr(channel) - static_cast<uint32_t>(ticks);
        if (in > 0 && in <= to - ticks) match(*counter, channel);
      }
    }
    ticks = to;
    if (ticks >= burst_end_) fill_burst();
    if (ticks >= sent_at_) {
      sent_at_ = kNever;
      Bus::cells[0x40026404] |= 0x0800'0000;  // TCIF7
    }
  }

  void run_interrupts(TestedBoard& board, Firmware& firmware) {
    if (steps_.pending()) OnInterrupt::step(board, firmware);
    if (interlock_closed != interlock_before_) {
      interlock_before_ = interlock_closed;
      OnInterrupt::interlock(board, firmware);
    }
    if (Bus::cells[0x40026404] & 0x0800'0000) OnInterrupt::line_out(board);
    if (clock_.pending()) OnInterrupt::alarm(board, firmware);
    if (Bus::cells[0x40026400] & 0x20) OnInterrupt::samples(board, firmware);
    if (ticks / kTicksPerMs != last_tick_) {
      last_tick_ = ticks / kTicksPerMs;
      OnInterrupt::tick(board);
    }
    Bus::take_writes();
  }

 private:
  struct Counter {
    uint32_t base, status = 0;
    uint32_t ccr(int channel) const { return Bus::cells[base + 0x30 + 4 * static_cast<uint32_t>(channel)]; }
    uint32_t enabled() const { return Bus::cells[base + 0x0C]; }
    bool pending() const { return (status & enabled()) != 0; }
    uint32_t mode(int channel) const {
      const uint32_t ccmr = Bus::cells[base + (channel <= 2 ? 0x18 : 0x1C)];
      return ccmr >> (channel % 2 == 1 ? 4 : 12) & 7;
    }
  };

  static volatile void* memory(uint32_t address) {
    return const_cast<volatile void*>(Bus::memory.at((address - 0x2000'0000) / 0x1'0000));
  }

  void set_step_pin(int channel, bool high) {
    bool& pin = step_pins_[channel - 3];
    if (high && !pin) {
      const bool up = directions_ >> (channel == 3 ? 6 : 7) & 1;
      (channel == 3 ? table : slide) += up ? 1 : -1;
    }
    pin = high;
  }
  void match(Counter& counter, int channel) {
    counter.status |= 1u << channel;
    if (counter.base == kTim2 && channel >= 3 && counter.mode(channel) == 1) set_step_pin(channel, true);
  }

  // Camera 1 sees 1,000 + electrode, camera 2 2,000 + electrode, of 12 bits, with a bit of noise.
  void fill_burst() {
    burst_end_ = kNever;
    ++bursts;
    auto* words = static_cast<volatile uint16_t*>(memory(Bus::cells[0x4002641C]));
    const uint32_t count = Bus::cells[0x40026414];
    for (uint32_t k = 0; k < count; ++k) {
      words[2 * k] = static_cast<uint16_t>(1'000 + k % 4);
      words[2 * k + 1] = static_cast<uint16_t>(2'000 + k % 4);
    }
    Bus::cells[0x40026414] = 0;
    Bus::cells[0x40026400] |= 0x20;  // TCIF0
    Bus::cells[kTim8] &= ~1u;        // one pulse
  }

  void about_to_read(uint32_t address) {
    if (address == kTim2 + 0x24 || address == kTim5 + 0x24)
      Bus::cells[address] = static_cast<uint32_t>(ticks);
    if (address == kTim2 + 0x10) Bus::cells[address] = steps_.status;
    if (address == kTim5 + 0x10) Bus::cells[address] = clock_.status;
    if (address == 0x40020410) {
      // Interlock, mirrors, laser driver; table and slide home.
      Bus::cells[address] = (interlock_closed ? 1u << 6 : 0) | 3u << 7 | (table <= 0 ? 1u << 9 : 0) |
                            (slide <= 0 ? 1u << 5 : 0);
    }
    if (address == 0x40020810) Bus::cells[address] = 3u << 9;  // no end switch
  }

  void written(uint32_t address, uint32_t value) {
    switch (address) {
      case 0x40023800:  // RCC_CR: ready bits follow
        Bus::cells[address] = value | (value & 0x0101'0000) << 1;
        break;
      case 0x40023808:  // RCC_CFGR: SWS follows SW
        Bus::cells[address] = value | (value & 3) << 2;
        break;
      case 0x50060800:
        Bus::cells[0x50060804] = 1;  // RNG: a number
        Bus::cells[0x50060808] = 0x1234'5678;
        break;
      case 0x40026428:  // DMA2_S1CR: a copy
        if (value & 1) {
          std::memcpy(const_cast<void*>(memory(Bus::cells[0x40026434])),
                      const_cast<const void*>(memory(Bus::cells[0x40026430])), 4 * Bus::cells[0x4002642C]);
          Bus::cells[0x40026400] |= 0x800;
        }
        break;
      case 0x400264B8:  // DMA2_S7CR: a stretch to the line, 11 us a byte
        if (value & 1) {
          const auto* from = static_cast<const volatile uint8_t*>(memory(Bus::cells[0x400264C4]));
          for (uint32_t k = 0; k < Bus::cells[0x400264BC]; ++k) line_out.push_back(uint8_t{from[k]});
          sent_at_ = ticks + 911 * Bus::cells[0x400264BC];
        }
        break;
      case 0x40026408:
        Bus::cells[0x40026400] &= ~value;
        break;
      case 0x4002640C:
        Bus::cells[0x40026404] &= ~value;
        break;
      case 0x40020418:  // GPIOB_BSRR: laser
        if (value & 1u << 12) laser_on = true;
        if (value & 1u << 28) laser_on = false;
        if (value & 1u << 14 && !laser_kick_) ++laser_kicks;  // rising edges
        if (value & 1u << 14) laser_kick_ = true;
        if (value & 1u << 30) laser_kick_ = false;
        break;
      case 0x40020818:  // GPIOC_BSRR: directions
        directions_ = (directions_ | (value & 0xFFFF)) & ~(value >> 16);
        break;
      case 0x40007420:
        mirrors = value;
        break;
      case kTim8:
        // As many triggers as the repetition counter says, if the converters want them and DMA takes them.
        if ((value & 9) == 9 && Bus::cells[kTim8 + 4] == 0x40 && Bus::cells[0x40012008] == 0x1E00'0001 &&
            Bus::cells[0x40012304] == 0x18006 && (Bus::cells[0x40026410] & 1))
          burst_end_ = ticks + 840 * (Bus::cells[kTim8 + 0x30] + 1);
        break;
      default:
        break;
    }
    for (Counter* counter : {&steps_, &clock_}) {
      if (address == counter->base + 0x10) counter->status &= value;
      for (int channel = 1; channel <= 4; ++channel) {
        if (address == counter->base + 0x14 && (value >> channel & 1)) match(*counter, channel);
      }
    }
    for (int channel = 3; channel <= 4; ++channel) {
      if (steps_.mode(channel) == 4) set_step_pin(channel, false);
      if (steps_.mode(channel) == 5) set_step_pin(channel, true);
    }
  }

  Counter steps_{kTim2}, clock_{kTim5};
  bool step_pins_[2] = {}, interlock_before_ = true, laser_kick_ = false;
  uint32_t directions_ = 0;
  uint64_t burst_end_ = kNever, sent_at_ = kNever, last_tick_ = 0;
};

class WholeMachine : public testing::Test {
 protected:
  void SetUp() override {
    board = std::make_unique<TestedBoard>(StartInfo{&kept, [](bool) {}, [] { return 0u; }});
    board->begin();
    Bus::take_writes();
    firmware = std::make_unique<Firmware>(*board);
    firmware->begin();
  }

  void run_ms(uint64_t ms) {
    run_until([] { return false; }, ms);
  }
  template <class Done>
  bool run_until(Done done, uint64_t ms) {
    const uint64_t end = chip.ticks + ms * kTicksPerMs;
    while (chip.ticks < end && !done()) {
      chip.advance_to(std::min(end, chip.next_event()));
      chip.run_interrupts(*board, *firmware);
      firmware->poll();
      Bus::take_writes();
      take_frames();
    }
    return done();
  }

  void send(Channel channel, const tg_HostMessage& message) {
    uint8_t wire[kFrameWireBytes];
    const size_t bytes = encode_message({channel, next_id++}, message, wire);
    chip.line_in(wire, bytes);
  }
  // The reply; nothing of it when none came within 400 ms.
  tg_MachineMessage ask(const tg_HostMessage& message) {
    reply.which_body = 0;
    send(Channel::kRequest, message);
    EXPECT_TRUE(run_until([&] { return reply.which_body != 0; }, 400));
    return reply;
  }
  tg_MachineMessage ask(pb_size_t tag) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tag;
    return ask(message);
  }
  void take_frames() {
    for (; !chip.line_out.empty(); chip.line_out.pop_front()) {
      if (!reader.push(chip.line_out.front())) continue;
      tg_MachineMessage message = tg_MachineMessage_init_zero;
      ASSERT_TRUE(decode_message(reader.frame(), &message));
      if (reader.frame().header.channel == Channel::kReply) reply = message;
      if (message.which_body == tg_MachineMessage_scan_end_tag) ends.push_back(message.body.scan_end);
      if (message.which_body == tg_MachineMessage_log_tag) logs.emplace_back(message.body.log.text);
      if (message.which_body == tg_MachineMessage_heartbeat_tag && answers) {
        tg_HostMessage ack = tg_HostMessage_init_zero;
        ack.which_body = tg_HostMessage_heartbeat_ack_tag;
        ack.body.heartbeat_ack.counter = message.body.heartbeat.counter;
        send(Channel::kEvent, ack);
      }
    }
  }
  void hello() {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_hello_tag;
    message.body.hello.protocol_version = kProtocolVersion;
    const tg_MachineMessage said = ask(message);
    ASSERT_EQ(said.which_body, tg_MachineMessage_hello_reply_tag);
    EXPECT_STREQ(said.body.hello_reply.board, "stm32_h405");
    EXPECT_EQ(said.body.hello_reply.reset_cause, tg_ResetCause_RESET_POWER);
  }
  void home() {
    hello();
    ASSERT_EQ(ask(tg_HostMessage_home_tag).which_body, tg_MachineMessage_done_tag);
    ASSERT_TRUE(run_until([&] { return firmware->state() == tg_State_STATE_READY; }, 60'000));
  }

  uint32_t kept = 0;
  Chip chip;
  std::unique_ptr<TestedBoard> board;
  std::unique_ptr<Firmware> firmware;
  FrameReader reader;
  tg_MachineMessage reply = tg_MachineMessage_init_zero;
  std::vector<std::string> logs;
  std::vector<tg_ScanEnd> ends;
  uint32_t next_id = 1;
  bool answers = true;
};

TEST_F(WholeMachine, AChipThatHasAllPassesItsSelfTest) {
  hello();
  run_ms(100);  // the clock check wants two stretches
  const tg_MachineMessage said = ask(tg_HostMessage_self_test_tag);
  ASSERT_EQ(said.which_body, tg_MachineMessage_self_test_tag);
  const tg_SelfTestReply& test = said.body.self_test;
  for (pb_size_t k = 0; k < test.items_count; ++k) {
    EXPECT_EQ(test.items[k].result, tg_SelfTestResult_SELF_TEST_PASSED)
        << "check " << test.items[k].check << ": " << test.items[k].value << " against "
        << test.items[k].limit;
  }
  // 12 bits in 15; electrode y2 has the largest code.
  const auto value_of = [&test](tg_SelfTestCheck check) { return test.items[check - 1].value; };
  EXPECT_EQ(value_of(tg_SelfTestCheck_CHECK_DARK_CAMERA_1), 1'003 * 8);
  EXPECT_EQ(value_of(tg_SelfTestCheck_CHECK_DARK_CAMERA_2), 2'003 * 8);
  ASSERT_EQ(test.dark_codes_count, 8u);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(test.dark_codes[k], (1'000 + k) * 8);
    EXPECT_EQ(test.dark_codes[4 + k], (2'000 + k) * 8);
  }
  EXPECT_EQ(value_of(tg_SelfTestCheck_CHECK_CONVERTER), 10'000);
  EXPECT_EQ(test.items_count, 12u);
  EXPECT_EQ(chip.bursts, 8u);
  EXPECT_EQ(logs, std::vector<std::string>{"no calibration in the store: nominal numbers are in use"});
  EXPECT_FALSE(board->faults().any());
}

TEST_F(WholeMachine, HomesByItsStepPinsAndSwitches) {
  home();
  // Both latched on the first step above the switch's edge; motors and firmware agree on every step since.
  const tg_Status status = ask(tg_HostMessage_get_status_tag).body.status;
  EXPECT_TRUE(status.homed);
  EXPECT_EQ(status.home_spread_table_udeg, 0u);
  EXPECT_EQ(status.home_spread_slide_um, 0u);
  const int64_t table = chip.table, slide = chip.slide;
  tg_HostMessage jog = tg_HostMessage_init_zero;
  jog.which_body = tg_HostMessage_jog_tag;
  jog.body.jog = {tg_AxisName_AXIS_SLIDE, 2'000};
  ASSERT_EQ(ask(jog).which_body, tg_MachineMessage_done_tag);
  ASSERT_TRUE(run_until([&] { return chip.slide == slide + 400; }, 10'000)) << "5 um a step";
  run_ms(100);
  EXPECT_EQ(chip.slide, slide + 400);
  EXPECT_EQ(chip.table, table);
}

TEST_F(WholeMachine, MirrorsMoveAndTheLaserObeysSilenceAndInterlock) {
  home();
  tg_HostMessage move = tg_HostMessage_init_zero;
  move.which_body = tg_HostMessage_move_galvo_tag;
  move.body.move_galvo = {170'001, 0};  // beyond what the built-in converters reach
  EXPECT_EQ(ask(move).body.refused.reason, tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  move.body.move_galvo = {96'000, -48'000};  // 1,000 and -500 steps of 12 bits
  ASSERT_EQ(ask(move).which_body, tg_MachineMessage_done_tag);
  EXPECT_EQ(chip.mirrors, (2'048u - 500) << 16 | (2'048 + 1'000));

  tg_HostMessage laser = tg_HostMessage_init_zero;
  laser.which_body = tg_HostMessage_laser_set_tag;
  laser.body.laser_set.on = true;
  ASSERT_FALSE(chip.laser_on);
  ASSERT_EQ(ask(laser).which_body, tg_MachineMessage_done_tag);
  EXPECT_TRUE(chip.laser_on);
  const uint32_t kicks = chip.laser_kicks;
  run_ms(1'000);
  EXPECT_TRUE(chip.laser_on);
  EXPECT_GE(chip.laser_kicks, kicks + 499) << "every second millisecond";

  answers = false;  // the host falls silent
  EXPECT_TRUE(run_until([&] { return !chip.laser_on; }, 500));
  EXPECT_EQ(firmware->state(), tg_State_STATE_PAUSED);

  answers = true;
  ASSERT_EQ(ask(tg_HostMessage_scan_resume_tag).which_body, tg_MachineMessage_done_tag);
  EXPECT_TRUE(chip.laser_on);
  chip.interlock_closed = false;
  chip.run_interrupts(*board, *firmware);
  EXPECT_FALSE(chip.laser_on) << "in the interrupt itself";
  run_ms(2);
  EXPECT_EQ(firmware->state(), tg_State_STATE_ESTOP);
}

TEST_F(WholeMachine, AScanMeasuresEveryRayByAlarmsAndBursts) {
  home();
  tg_HostMessage load = tg_HostMessage_init_zero;
  load.which_body = tg_HostMessage_scan_load_tag;
  load.body.scan_load.plan_id = 7;
  load.body.scan_load.total_views = 1;
  load.body.scan_load.views_count = 1;
  load.body.scan_load.views[0] = small_view();
  ASSERT_EQ(ask(load).which_body, tg_MachineMessage_done_tag);
  tg_HostMessage credit = tg_HostMessage_init_zero;
  credit.which_body = tg_HostMessage_points_credit_tag;
  credit.body.points_credit = {7, 0, 30};
  send(Channel::kEvent, credit);
  tg_HostMessage start = tg_HostMessage_init_zero;
  start.which_body = tg_HostMessage_scan_start_tag;
  start.body.scan_start.plan_id = 7;
  const uint32_t kicks = chip.laser_kicks;
  ASSERT_EQ(ask(start).which_body, tg_MachineMessage_done_tag);
  ASSERT_TRUE(run_until([&] { return !ends.empty(); }, 60'000));
  // These cameras see the same with the laser on and off.
  EXPECT_EQ(ends[0].fault, tg_FaultCode_FAULT_NONE);
  EXPECT_FALSE(ends[0].aborted);
  EXPECT_EQ(ends[0].points, 0u);
  EXPECT_EQ(ends[0].rejected, kSmallViewRays);
  EXPECT_GE(chip.bursts, 3 * kSmallViewRays) << "off, on, off";
  EXPECT_GE(chip.laser_kicks - kicks, kSmallViewRays) << "each time it goes on";
  EXPECT_FALSE(chip.laser_on);
  EXPECT_FALSE(board->faults().any());
}

}  // namespace
}  // namespace tetragauge
