// SPDX-License-Identifier: Apache-2.0
// One more board: the pins of the firmware's Board concept, wired to the simulated world, in virtual time.
// run_board() moves the time on; the board only says what is due when.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "boards/emulated/host_line.hpp"
#include "boards/emulated/trace.hpp"
#include "firmware/hal/board.hpp"
#include "protocol/machine.pb.h"
#include "sim/world.hpp"

namespace tetragauge {

class EmulatedBoard {
 public:
  static constexpr const char* kName = "emulated";
  static constexpr uint32_t kCapabilities =
      tg_Capability_CAPABILITY_EMULATED | tg_Capability_CAPABILITY_ADC_16_BIT;
  // The converter's own filter lets 17 kHz of noise through: samples 30 us apart are independent.
  static constexpr uint32_t kSamplePeriodNs = 30'000;
  static constexpr int32_t kMirrorCodeStep = 1;
  static constexpr int32_t kMirrorReachUrad = 32'767 * kUradPerMirrorCode;
  static constexpr uint32_t kStepTicksPerSecond = 1'000'000'000;

  static constexpr uint64_t kNever = std::numeric_limits<uint64_t>::max();

  // `boot_id` should differ between starts; it has no influence on what is measured. `trace`: may be null.
  EmulatedBoard(sim::World& world, HostLine& line, Storage& store, uint32_t boot_id, Trace* trace = nullptr);

  uint32_t boot_id() const { return boot_id_; }
  uint64_t now_ns() const { return now_ns_; }
  void set_alarm_ns(uint64_t time_ns) { alarm_ns_ = time_ns; }
  void set_mirrors(int16_t a_code, int16_t b_code);
  void set_laser(bool on);
  void start_samples(PsdSample* samples, uint32_t count);
  uint64_t step_clock() const { return now_ns_; }
  bool schedule_step(Axis axis, uint64_t tick, int direction);
  bool cancel_step(Axis axis);
  uint32_t inputs() const;
  size_t read(uint8_t* bytes, size_t capacity) { return line_.read(bytes, capacity, now_ns_); }
  size_t write(const uint8_t* bytes, size_t count) { return line_.write(bytes, count, now_ns_); }
  void mask_interrupts(bool) {}  // one thread: no interrupt comes while the firmware runs
  void kick_watchdog() {}        // a loop that hangs is seen by whoever waits for the program

  Storage& storage() { return store_; }
  tg_ResetCause reset_cause() const { return reset_cause_; }
  void restart(bool into_bootloader);
  uint32_t stack_free_bytes() const { return 0; }
  bool self_check(tg_SelfTestCheck, tg_SelfTestItem*) { return false; }

  Trace* trace() const { return trace_; }

  // For run_board(): what restart() asked for, once. The store and the world stay as they are.
  enum class Restart { no, firmware, bootloader };
  Restart take_restart();

  // For run_board(): the interrupts in order of priority, each at its time or kNever.
  enum class Event { table_step, slide_step, interlock, alarm, samples, none };
  struct Due {
    Event event = Event::none;
    uint64_t time_ns = kNever;
  };
  Due next_event() const;
  // Moves the clock to the event's time (the past means now), takes it off the list and does its hardware
  // part.
  void take(const Due& due);
  void advance_to(uint64_t time_ns);

 private:
  int64_t world_ns() const { return static_cast<int64_t>(now_ns_); }

  sim::World& world_;
  HostLine& line_;
  Storage& store_;
  uint32_t boot_id_;
  Trace* trace_;
  tg_ResetCause reset_cause_ = tg_ResetCause_RESET_POWER;
  Restart restart_ = Restart::no;
  uint64_t now_ns_ = 0;
  uint64_t alarm_ns_ = kNever, burst_end_ns_ = kNever;
  std::array<uint64_t, kAxes> step_ns_{kNever, kNever};
  std::array<int, kAxes> step_direction_{};
  PsdSample* burst_ = nullptr;
  uint32_t burst_count_ = 0, burst_taken_ = 0;
  uint64_t burst_start_ns_ = 0;

  void take_samples_until_now();
  void make_step(Axis axis);
};

static_assert(Board<EmulatedBoard>);

}  // namespace tetragauge
