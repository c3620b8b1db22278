// SPDX-License-Identifier: Apache-2.0
// What a board gives to the firmware. The controller is a template on the board, so a chip's calls compile to
// register accesses; the emulated board is one more board. hal/fake_board.hpp is the smallest one.
//
// Timing contract. A board has one clock that never goes back and counts from start-up. It calls the
// controller's interrupt entry points AT the instants it was asked for, never early; now_ns() read inside is
// that instant or later:
//   controller.on_alarm()        at the time of set_alarm_ns (one pending alarm; setting it again replaces
//   it) controller.on_samples()      when the burst of start_samples is in the buffer
//   controller.on_step_timer(k)  after the edge of schedule_step(k, ...) has come
//   controller.on_interlock()    when the interlock opens or closes
// Priorities, high to low: step timers, interlock, alarm and samples (these two never interrupt each other),
// poll(). poll() is the main loop: call it after bytes came, after every interrupt, and not later than
// next_poll_ns().
//
// Step edges are made by timer hardware (a compare channel that toggles or pulses the pin): an edge comes at
// the tick it was scheduled for, whatever the processor does then. The firmware schedules one ahead, from
// on_step_timer of the edge before, so an interrupt may be late by up to an interval without moving any edge.
// The step clock counts ticks of that timer from start-up, extended to 64 bits; no edge is scheduled more
// than 4 s ahead.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "firmware/hal/storage.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

// One simultaneous sample of both cameras: signed converter codes, left-aligned to 16 bits (a 12-bit
// converter shifts by 4), one electrode current each. Duolateral detector: each pair carries the whole
// photocurrent; x = half_size (x2 - x1) / (x2 + x1), y alike.
struct alignas(4) PsdSample {  // a chip's DMA writes words
  struct Camera {
    int16_t x1, x2, y1, y2;
  };
  Camera camera[2];
};

inline constexpr uint32_t kBurstSamples = 64;  // longest burst

// Mirror converters: signed code, kUradPerMirrorCode of mechanical mirror angle each.
// A coarser converter does only every kMirrorCodeStep-th code; the firmware asks it for no other.
inline constexpr int32_t kUradPerMirrorCode = 6;

enum class Axis : uint8_t { kTable = 0, kSlide = 1 };
inline constexpr int kAxes = 2;

struct Inputs {
  static constexpr uint32_t kInterlockClosed = 1;  // laser and motion allowed
  static constexpr uint32_t kMirrorsGood = 2;      // both galvo drivers ready, position error small
  static constexpr uint32_t kLaserGood = 4;        // laser driver ready
  static constexpr uint32_t kTableHome = 8;        // home switch closed: position at or below home_steps
  static constexpr uint32_t kSlideHome = 16;
  static constexpr uint32_t kSlideLimitLow = 32;  // end switches of the slide; the table turns freely
  static constexpr uint32_t kSlideLimitHigh = 64;
};

template <class B>
concept Board = requires(B board, const B& constant, uint64_t time_ns, uint64_t tick, int direction,
                         int16_t code, PsdSample* samples, uint32_t count, Axis axis, bool on, uint8_t* in,
                         const uint8_t* out, size_t bytes, tg_SelfTestCheck check, tg_SelfTestItem* item) {
  { B::kName } -> std::convertible_to<const char*>;
  { B::kCapabilities } -> std::convertible_to<uint32_t>;    // tg_Capability bits
  { B::kSamplePeriodNs } -> std::convertible_to<uint32_t>;  // between samples of a burst
  { constant.boot_id() } -> std::same_as<uint32_t>;         // differs between starts

  { constant.now_ns() } -> std::same_as<uint64_t>;
  { board.set_alarm_ns(time_ns) } -> std::same_as<void>;

  { B::kMirrorCodeStep } -> std::convertible_to<int32_t>;
  { B::kMirrorReachUrad } -> std::convertible_to<int32_t>;  // either sign; nominal limits end there
  { board.set_mirrors(code, code) } -> std::same_as<void>;  // a, b; both at once
  { board.set_laser(on) } -> std::same_as<void>;
  // First sample one period after the call; the whole burst takes count periods.
  { board.start_samples(samples, count) } -> std::same_as<void>;

  { B::kStepTicksPerSecond } -> std::convertible_to<uint32_t>;
  { constant.step_clock() } -> std::same_as<uint64_t>;  // now, in ticks
  // One edge at that tick (one pending for each axis). Direction +1: up / counter-clockwise, -1: the other
  // way, 0: none, only the interrupt (self-test). False when the tick had passed: it comes at once.
  { board.schedule_step(axis, tick, direction) } -> std::same_as<bool>;
  // True: the edge never comes, nor on_step_timer for it. False: it is out, and on_step_timer is yet to come.
  { board.cancel_step(axis) } -> std::same_as<bool>;
  { constant.inputs() } -> std::same_as<uint32_t>;

  { board.read(in, bytes) } -> std::same_as<size_t>;    // takes what came, up to bytes
  { board.write(out, bytes) } -> std::same_as<size_t>;  // takes what fits, returns how many
  {
    board.mask_interrupts(on)
    } -> std::same_as<void>;  // alarm, samples, interlock, step timers; never nested
  { board.kick_watchdog() } -> std::same_as<void>;

  // Cold parts.
  { board.storage() } -> std::same_as<Storage&>;
  { constant.reset_cause() } -> std::same_as<tg_ResetCause>;  // why the firmware started
  // The line is flushed. A chip does not come back from it; an emulated board starts a new firmware when the
  // controller has returned, and the controller does nothing more.
  { board.restart(on) } -> std::same_as<void>;                // true: into the chip's bootloader
  { constant.stack_free_bytes() } -> std::same_as<uint32_t>;  // never used since start-up; 0: cannot tell
  // What only the board can check, CHECK_CLOCK and CHECK_TRANSPORT: result, value and limit into the item.
  // False: the board has no such check.
  { board.self_check(check, item) } -> std::same_as<bool>;
};

}  // namespace tetragauge
