// SPDX-License-Identifier: Apache-2.0
// Steps, alarm and the long count, on timers that behave as RM0090 chapter 18 says: a model of its own here,
// driven tick by tick.
#include <gtest/gtest.h>

#include "boards/stm32_h405/alarm_clock.hpp"
#include "boards/stm32_h405/recorded_bus.hpp"
#include "boards/stm32_h405/step_timer.hpp"

namespace tetragauge {
namespace {

using Bus = RecordedBus;

// A 32-bit timer with compare channels 1, 3 and 4 and their pins.
class TimerModel {
 public:
  explicit TimerModel(uint32_t base) : base_(base) {
    Bus::reset();
    Bus::on_write = [this](uint32_t address, uint32_t value) { written(address, value); };
    Bus::on_read = [this](uint32_t address) {
      if (address == base_ + 0x24) {
        Bus::cells[address] = static_cast<uint32_t>(count);
        advance(ticks_a_look);
      }
    };
  }
  ~TimerModel() { Bus::reset(); }

  void advance(uint64_t ticks) {
    for (uint64_t k = 0; k < ticks; ++k) {
      ++count;
      if (static_cast<uint32_t>(count) == 0) status_ |= 1;
      for (int channel = 1; channel <= 4; ++channel) {
        if (ccr(channel) == static_cast<uint32_t>(count)) match(channel);
      }
      publish();
    }
  }
  void jump_to(uint64_t to) { count = to; }
  bool interrupt() const { return (status_ & Bus::cells[base_ + 0x0C]) != 0; }
  bool pin(int channel) const { return pins_[channel]; }

  uint64_t count = 0;
  uint32_t ticks_a_look = 0;       // time that passes at each look at the counter
  std::vector<uint64_t> rises[5];  // of each channel's pin
  std::vector<uint64_t> falls[5];

 private:
  uint32_t ccr(int channel) const { return Bus::cells[base_ + 0x30 + 4 * static_cast<uint32_t>(channel)]; }
  uint32_t mode(int channel) const {
    const uint32_t ccmr = Bus::cells[base_ + 0x18 + 4 * static_cast<uint32_t>((channel - 1) / 2)];
    return ccmr >> (8 * ((channel - 1) % 2) + 4) & 7;
  }
  void set_pin(int channel, bool high) {
    if (pins_[channel] != high) (high ? rises : falls)[channel].push_back(count);
    pins_[channel] = high;
  }
  void match(int channel) {
    status_ |= 1u << channel;
    if (mode(channel) == 1) set_pin(channel, true);
  }
  void written(uint32_t address, uint32_t value) {
    if (address == base_ + 0x10) status_ &= value;  // rc_w0
    if (address == base_ + 0x14) {
      for (int channel = 1; channel <= 4; ++channel) {
        if (value >> channel & 1) match(channel);
      }
    }
    for (int channel = 1; channel <= 4; ++channel) {
      if (mode(channel) == 4) set_pin(channel, false);
      if (mode(channel) == 5) set_pin(channel, true);
    }
    publish();
  }
  void publish() { Bus::cells[base_ + 0x10] = status_; }

  uint32_t base_, status_ = 0;
  bool pins_[5] = {};
};

constexpr uint32_t kTim2 = 0x40000000, kTim5 = 0x40000C00;

TEST(StepTimer, EdgesComeAtTheirTicksHoweverLateTheInterrupt) {
  TimerModel model(kTim2);
  StepTimer<Bus> steps;
  steps.begin();
  model.ticks_a_look = 3;
  // 200 kHz is every 420 ticks; both axes, the interrupt late by up to 300.
  std::vector<uint64_t> wanted[kAxes];
  uint64_t next[kAxes] = {1'000, 1'133};
  const auto ask = [&](Axis axis) {
    const int k = static_cast<int>(axis);
    EXPECT_TRUE(steps.schedule(axis, next[k], +1));
    wanted[k].push_back(next[k]);
    next[k] += 420;
  };
  ask(Axis::kTable);
  ask(Axis::kSlide);
  uint32_t late = 0, seed = 1;
  while (wanted[0].size() < 500) {
    model.advance(1);
    if (!model.interrupt()) {
      seed = seed * 1664525u + 1013904223u;
      late = (seed >> 8) % 300;
    } else if (late > 0) {
      --late;
    } else {
      steps.on_interrupt(ask);
    }
  }
  for (int k = 0; k < kAxes; ++k) {
    const int channel = 3 + k;
    ASSERT_GE(model.rises[channel].size(), wanted[k].size() - 2);
    for (size_t i = 0; i < model.rises[channel].size(); ++i) EXPECT_EQ(model.rises[channel][i], wanted[k][i]);
    for (size_t i = 0; i < model.falls[channel].size(); ++i) {
      EXPECT_GE(model.falls[channel][i] - model.rises[channel][i], StepTimer<Bus>::kPulseTicks);
      EXPECT_LT(model.falls[channel][i], wanted[k][i] + 420);
    }
  }
}

TEST(StepTimer, TheLastPulseEndsToo) {
  TimerModel model(kTim2);
  StepTimer<Bus> steps;
  steps.begin();
  model.ticks_a_look = 3;
  steps.schedule(Axis::kSlide, 100, -1);
  EXPECT_EQ(Bus::cells[0x40020818], 1u << (7 + 16)) << "direction pin low";
  int edges = 0;
  while (edges == 0) {
    model.advance(1);
    if (model.interrupt()) steps.on_interrupt([&](Axis axis) { edges += axis == Axis::kSlide ? 1 : 100; });
  }
  EXPECT_EQ(edges, 1);
  EXPECT_FALSE(model.pin(4));
  ASSERT_EQ(model.falls[4].size(), 1u);
  EXPECT_GE(model.falls[4][0], 100 + StepTimer<Bus>::kPulseTicks);
  EXPECT_FALSE(model.interrupt());
}

TEST(StepTimer, ATickThatHasPassedComesAtOnceAndIsSaid) {
  TimerModel model(kTim2);
  StepTimer<Bus> steps;
  steps.begin();
  model.advance(500);
  EXPECT_FALSE(steps.schedule(Axis::kTable, 499, +1));
  ASSERT_EQ(model.rises[3].size(), 1u);
  EXPECT_EQ(model.rises[3][0], 500u);
  EXPECT_TRUE(model.interrupt());
}

TEST(StepTimer, DirectionNoneInterruptsWithoutAnEdge) {
  TimerModel model(kTim2);
  StepTimer<Bus> steps;
  steps.begin();
  EXPECT_TRUE(steps.schedule(Axis::kTable, 50, 0));
  model.advance(60);
  EXPECT_TRUE(model.interrupt());
  EXPECT_TRUE(model.rises[3].empty());
}

TEST(StepTimer, CancelTellsWhetherTheEdgeIsOut) {
  TimerModel model(kTim2);
  StepTimer<Bus> steps;
  steps.begin();
  steps.schedule(Axis::kTable, 100, +1);
  model.advance(50);
  EXPECT_TRUE(steps.cancel(Axis::kTable));
  model.advance(100);
  EXPECT_TRUE(model.rises[3].empty());
  EXPECT_FALSE(model.interrupt());

  steps.schedule(Axis::kTable, 200, +1);
  model.advance(100);
  EXPECT_FALSE(steps.cancel(Axis::kTable));
  EXPECT_EQ(model.rises[3].size(), 1u);
  int edges = 0;
  model.ticks_a_look = 3;
  steps.on_interrupt([&](Axis) { ++edges; });
  EXPECT_EQ(edges, 1) << "the interrupt of an edge that is out still comes";
}

TEST(LongCount, OverflowIsSeenBeforeAndAfterItsInterrupt) {
  TimerModel model(kTim2);
  LongCount<Bus, Tim2> count;
  count.begin();
  model.jump_to(0xFFFF'FFF0);
  EXPECT_EQ(count.now(), 0xFFFF'FFF0u);
  model.advance(0x20);
  EXPECT_EQ(count.now(), 0x1'0000'0010u);
  count.on_interrupt();
  EXPECT_EQ(count.now(), 0x1'0000'0010u);
  count.on_interrupt();
  EXPECT_EQ(count.now(), 0x1'0000'0010u);
}

TEST(LongCount, NeverGoesBackWhileTheCounterOverflowsBetweenItsLooks) {
  for (uint32_t start = 0; start < 16; ++start) {
    TimerModel model(kTim2);
    LongCount<Bus, Tim2> count;
    count.begin();
    model.ticks_a_look = 5;  // an overflow between the look at the counter and the one at its flag
    model.jump_to(0xFFFF'FFF0 + start);
    uint64_t before = 0;
    for (int look = 0; look < 8; ++look) {
      const uint64_t truth = model.count;
      const uint64_t now = count.now();
      EXPECT_EQ(now, truth);
      EXPECT_GT(now, before);
      before = now;
    }
  }
}

TEST(AlarmClock, ComesAtItsTimeAndNotBefore) {
  for (const uint64_t time_ns : {1u, 11u, 12u, 1'000u, 12'345u, 99'999u}) {
    TimerModel model(kTim5);
    AlarmClock<Bus> clock;
    clock.begin();
    clock.set_alarm_ns(time_ns);
    while (!model.interrupt()) model.advance(1);
    EXPECT_TRUE(clock.on_interrupt());
    EXPECT_GE(clock.now_ns(), time_ns);
    EXPECT_LE(clock.now_ns(), time_ns + 12) << "a tick is 11.9 ns";
    EXPECT_FALSE(model.interrupt());
    EXPECT_FALSE(clock.on_interrupt());
  }
}

TEST(AlarmClock, TheNewTimeReplacesTheOldAndThePastComesAtOnce) {
  TimerModel model(kTim5);
  AlarmClock<Bus> clock;
  clock.begin();
  clock.set_alarm_ns(5'000);
  clock.set_alarm_ns(10'000);
  model.advance(500);
  EXPECT_FALSE(model.interrupt());
  model.advance(400);
  EXPECT_TRUE(clock.on_interrupt());
  clock.set_alarm_ns(10);
  EXPECT_TRUE(model.interrupt());
  EXPECT_TRUE(clock.on_interrupt());
}

TEST(AlarmClock, AMatchATurnTooEarlyIsNone) {
  TimerModel model(kTim5);
  AlarmClock<Bus> clock;
  clock.begin();
  clock.set_alarm_ns(60'000'000'000);  // 51.1 s a turn
  const uint64_t tick = 60'000ull * 84'000;
  model.jump_to(tick % 0x1'0000'0000 - 5);
  model.advance(10);
  EXPECT_TRUE(model.interrupt());
  EXPECT_FALSE(clock.on_interrupt());
}

}  // namespace
}  // namespace tetragauge
