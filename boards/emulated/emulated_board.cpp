// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/emulated_board.hpp"

#include <algorithm>
#include <utility>

namespace tetragauge {

EmulatedBoard::EmulatedBoard(sim::World& world, HostLine& line, Storage& store, uint32_t boot_id,
                             Trace* trace)
    : world_(world), line_(line), store_(store), boot_id_(boot_id), trace_(trace) {}

// A burst sees mirrors and laser as they are at each sample's own time, so samples due are taken before a
// change.
void EmulatedBoard::take_samples_until_now() {
  while (burst_taken_ < burst_count_) {
    const uint64_t time_ns = burst_start_ns_ + uint64_t{burst_taken_ + 1} * kSamplePeriodNs;
    if (time_ns > now_ns_) return;
    const sim::World::Sample codes = world_.sample(static_cast<int64_t>(time_ns));
    PsdSample& out = burst_[burst_taken_++];
    for (size_t c = 0; c < 2; ++c) out.camera[c] = {codes[c].x1, codes[c].x2, codes[c].y1, codes[c].y2};
  }
}

void EmulatedBoard::set_mirrors(int16_t a_code, int16_t b_code) {
  take_samples_until_now();
  world_.set_mirrors(a_code, b_code, world_ns());
}

void EmulatedBoard::set_laser(bool on) {
  take_samples_until_now();
  if (trace_ != nullptr) trace_->laser(now_ns_, on);
  world_.set_laser(on, world_ns());
}

void EmulatedBoard::start_samples(PsdSample* samples, uint32_t count) {
  burst_ = samples;
  burst_count_ = count;
  burst_taken_ = 0;
  burst_start_ns_ = now_ns_;
  burst_end_ns_ = now_ns_ + uint64_t{count} * kSamplePeriodNs;
}

bool EmulatedBoard::schedule_step(Axis axis, uint64_t tick, int direction) {
  step_ns_[static_cast<size_t>(axis)] = std::max(tick, now_ns_);
  step_direction_[static_cast<size_t>(axis)] = direction;
  return tick >= now_ns_;
}

bool EmulatedBoard::cancel_step(Axis axis) {
  const bool still_to_come = step_ns_[static_cast<size_t>(axis)] != kNever;
  step_ns_[static_cast<size_t>(axis)] = kNever;
  return still_to_come;
}

// The edge, as the timer makes it; the interrupt follows.
void EmulatedBoard::make_step(Axis axis) {
  take_samples_until_now();
  step_ns_[static_cast<size_t>(axis)] = kNever;
  const int direction = step_direction_[static_cast<size_t>(axis)];
  if (direction == 0) return;
  world_.step(axis == Axis::kTable ? sim::Stage::table : sim::Stage::slide, direction > 0);
}

uint32_t EmulatedBoard::inputs() const {
  const sim::Switches s = world_.switches(world_ns());
  return (s.interlock_closed ? Inputs::kInterlockClosed : 0) | (s.mirrors_good ? Inputs::kMirrorsGood : 0) |
         (s.laser_good ? Inputs::kLaserGood : 0) | (s.table_home ? Inputs::kTableHome : 0) |
         (s.slide_home ? Inputs::kSlideHome : 0) | (s.slide_limit_low ? Inputs::kSlideLimitLow : 0) |
         (s.slide_limit_high ? Inputs::kSlideLimitHigh : 0);
}

void EmulatedBoard::restart(bool into_bootloader) {
  restart_ = into_bootloader ? Restart::bootloader : Restart::firmware;
}

EmulatedBoard::Restart EmulatedBoard::take_restart() {
  const Restart wanted = std::exchange(restart_, Restart::no);
  if (wanted != Restart::no) {
    set_laser(false);
    alarm_ns_ = burst_end_ns_ = kNever;
    step_ns_.fill(kNever);
    burst_count_ = burst_taken_ = 0;
    ++boot_id_;
    reset_cause_ = tg_ResetCause_RESET_SOFTWARE;
  }
  return wanted;
}

EmulatedBoard::Due EmulatedBoard::next_event() const {
  Due first;
  const auto offer = [&](Event event, uint64_t time_ns) {
    if (time_ns < first.time_ns) first = {event, time_ns};
  };
  offer(Event::table_step, step_ns_[0]);
  offer(Event::slide_step, step_ns_[1]);
  const int64_t change_ns = world_.next_switch_change_ns(world_ns());
  if (change_ns < std::numeric_limits<int64_t>::max())
    offer(Event::interlock, static_cast<uint64_t>(change_ns));
  offer(Event::alarm, alarm_ns_);
  offer(Event::samples, burst_end_ns_);
  return first;
}

void EmulatedBoard::advance_to(uint64_t time_ns) {
  now_ns_ = std::max(now_ns_, time_ns);
}

void EmulatedBoard::take(const Due& due) {
  advance_to(due.time_ns);
  switch (due.event) {
    case Event::table_step:
      make_step(Axis::kTable);
      break;
    case Event::slide_step:
      make_step(Axis::kSlide);
      break;
    case Event::interlock:  // the world has changed by itself
      break;
    case Event::alarm:
      alarm_ns_ = kNever;
      break;
    case Event::samples:
      take_samples_until_now();
      burst_end_ns_ = kNever;
      break;
    case Event::none:
      break;
  }
}

}  // namespace tetragauge
