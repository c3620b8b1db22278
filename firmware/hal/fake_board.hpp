// SPDX-License-Identifier: Apache-2.0
// The smallest board, in memory and virtual time, for the firmware's own tests: cameras that see an ideal
// matt plate by firmware/optics itself (so it tests the machine's behaviour, not its accuracy: the emulated
// board does that).
#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "firmware/hal/board.hpp"
#include "firmware/hal/memory_storage.hpp"
#include "firmware/optics/galvo.hpp"
#include "firmware/optics/nominal_geometry.hpp"
#include "firmware/optics/psd_camera.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

class FakeBoard {
 public:
  static constexpr const char* kName = "fake";
  static constexpr uint32_t kCapabilities = tg_Capability_CAPABILITY_EMULATED;
  static constexpr uint32_t kSamplePeriodNs = 10'000;
  static constexpr int32_t kMirrorCodeStep = 1;
  static constexpr int32_t kMirrorReachUrad = 32'767 * kUradPerMirrorCode;
  static constexpr uint32_t kStepTicksPerSecond = 1'000'000'000;
  static constexpr uint64_t kNever = ~uint64_t{0};

  uint32_t boot_id() const { return 7; }
  uint64_t now_ns() const { return now; }
  void set_alarm_ns(uint64_t time_ns) { alarm = time_ns; }
  void set_mirrors(int16_t a, int16_t b) {
    mirror_a = a, mirror_b = b;
    mirrors_set_ns = now;
  }
  void set_laser(bool on) {
    laser = on;
    if (on) {
      ++times_laser_on;
      when_laser_goes_on();
    }
  }
  void start_samples(PsdSample* samples, uint32_t count) {
    burst = samples;
    burst_count = count;
    burst_end = stuck_converter ? kNever : now + uint64_t{count} * kSamplePeriodNs;
  }
  uint64_t step_clock() const { return now; }
  bool schedule_step(Axis axis, uint64_t tick, int direction) {
    const int k = static_cast<int>(axis);
    step_edge[k] = tick > now ? tick : now;
    step_direction[k] = direction;
    return tick >= now;
  }
  bool cancel_step(Axis axis) {
    const bool still_to_come = step_edge[static_cast<int>(axis)] != kNever;
    step_edge[static_cast<int>(axis)] = kNever;
    return still_to_come;
  }
  // The timer's part of a step.
  void make_edge(int k) {
    step_edge[k] = kNever;
    position[k] += step_direction[k];
    // The carriage follows the motor when the play is taken up.
    if (position[k] > carriage[k]) carriage[k] = position[k];
    if (position[k] + play[k] < carriage[k]) carriage[k] = position[k] + play[k];
    if (step_direction[k] != 0) on_edge(k, now, step_direction[k]);
    step_interrupt[k] = now + interrupt_latency();
  }
  uint32_t inputs() const {
    uint32_t bits = needed_inputs;
    if (carriage[0] <= table_home) bits |= Inputs::kTableHome;
    if (carriage[1] <= slide_home) bits |= Inputs::kSlideHome;
    if (carriage[1] <= slide_home - 200) bits |= Inputs::kSlideLimitLow;
    if (carriage[1] >= slide_home + 61'000) bits |= Inputs::kSlideLimitHigh;
    return bits;
  }
  size_t read(uint8_t* bytes, size_t capacity) {
    size_t count = 0;
    while (count < capacity && !to_machine.empty()) {
      bytes[count++] = to_machine.front();
      to_machine.pop_front();
    }
    return count;
  }
  size_t write(const uint8_t* bytes, size_t count) {
    const size_t taken = count < line_room ? count : line_room;
    from_machine.insert(from_machine.end(), bytes, bytes + taken);
    return taken;
  }
  void mask_interrupts(bool) {}
  void kick_watchdog() { ++kicks; }
  Storage& storage() { return store; }
  tg_ResetCause reset_cause() const { return tg_ResetCause_RESET_POWER; }
  void restart(bool into_bootloader) { (into_bootloader ? bootloader_asked : restart_asked) = true; }
  uint32_t stack_free_bytes() const { return 0; }
  bool self_check(tg_SelfTestCheck, tg_SelfTestItem*) { return false; }

  uint64_t now = 0, alarm = kNever, burst_end = kNever, step_edge[kAxes] = {kNever, kNever};
  uint64_t step_interrupt[kAxes] = {kNever, kNever};
  int step_direction[kAxes] = {0, 0};
  std::function<uint64_t()> interrupt_latency = [] { return 0; };
  std::function<void(int, uint64_t, int)> on_edge = [](int, uint64_t, int) {};  // axis, tick, direction
  int16_t mirror_a = 0, mirror_b = 0;
  bool laser = false, stuck_converter = false, restart_asked = false, bootloader_asked = false;
  uint32_t times_laser_on = 0;
  std::function<void()> when_laser_goes_on = [] {};
  PsdSample* burst = nullptr;
  uint32_t burst_count = 0;
  int64_t position[kAxes] = {0, 0};                   // of the motor: edges made
  int64_t carriage[kAxes] = {0, 0};                   // what the switches feel
  int64_t play[kAxes] = {0, 0};                       // backlash of the true machine, in steps
  int64_t table_home = -18'000, slide_home = -1'000;  // the true edge of the switches
  uint32_t needed_inputs = Inputs::kInterlockClosed | Inputs::kMirrorsGood | Inputs::kLaserGood;
  std::deque<uint8_t> to_machine;
  std::vector<uint8_t> from_machine;
  size_t line_room = 4096;  // taken at each write
  uint64_t kicks = 0;
  MemoryStorage store;
  int ambient_codes = 100, light_codes = 30'000;  // of a whole pair
  double plate_x_mm = 0;                          // the plate is the plane x = plate_x_mm
  uint64_t mirrors_set_ns = 0;
  std::function<double(uint64_t)> mirror_lag_rad = [](uint64_t) {
    return 0.0;
  };                                                                 // of mirror a, by ns since set
  bool covered[2] = {false, false};                                  // something stands before the camera
  double camera_1_shift_mm = 0;                                      // on the detector: a camera out of place
  std::function<void(PsdSample&)> spoil_sample = [](PsdSample&) {};  // noise, and whatever else goes wrong

  void fill_burst() {
    constexpr MachineGeometry<double> machine = nominal_geometry<double>();
    for (uint32_t i = 0; i < burst_count; ++i) {
      const uint64_t sampled_ns = now - uint64_t{burst_count - 1 - i} * kSamplePeriodNs;
      const double a = mirror_a * kUradPerMirrorCode * 1e-6 + mirror_lag_rad(sampled_ns - mirrors_set_ns);
      const Beam<double> beam = beam_from_mirrors(machine.galvo, a, mirror_b * kUradPerMirrorCode * 1e-6);
      const double range = (plate_x_mm - beam.origin.x) / beam.direction.x;
      const Vector3<double> spot = beam.origin + beam.direction * range;
      for (int c = 0; c < 2; ++c) {
        bool in_view = false;
        DetectorPosition<double> at = project(machine.camera[c], spot, &in_view);
        if (c == 0) at.x_mm += camera_1_shift_mm;
        const double light = laser && in_view && !covered[c] ? light_codes : 0;
        const double half = machine.camera[c].half_size_mm;
        const auto code = [&](double share) {
          const double value = ambient_codes / 2.0 + light * share;
          return static_cast<int16_t>(value > 32'767 ? 32'767 : value + 0.5);
        };
        burst[i].camera[c] = {code(0.5 - at.x_mm / half / 2), code(0.5 + at.x_mm / half / 2),
                              code(0.5 - at.y_mm / half / 2), code(0.5 + at.y_mm / half / 2)};
      }
      spoil_sample(burst[i]);
    }
  }
};

static_assert(Board<FakeBoard>);

// Runs a controller on it: the next thing due, once. False when nothing is due until `until_ns`.
template <class Firmware>
bool run_next(FakeBoard& board, Firmware& firmware, uint64_t until_ns) {
  uint64_t due = firmware.next_poll_ns();
  int what = -1;
  const auto consider = [&](uint64_t time_ns, int event) {
    if (time_ns <= due && time_ns != FakeBoard::kNever) {
      due = time_ns;
      what = event;
    }
  };
  consider(board.burst_end, 3);
  consider(board.alarm, 2);
  consider(board.step_interrupt[1], 1);
  consider(board.step_interrupt[0], 0);
  consider(board.step_edge[1], 5);
  consider(board.step_edge[0], 4);
  if (due > until_ns) {
    board.now = until_ns;
    return false;
  }
  if (due > board.now) board.now = due;
  switch (what) {
    case 0:
    case 1:
      board.step_interrupt[what] = FakeBoard::kNever;
      firmware.on_step_timer(static_cast<Axis>(what));
      break;
    case 2:
      board.alarm = FakeBoard::kNever;
      firmware.on_alarm();
      break;
    case 3:
      board.burst_end = FakeBoard::kNever;
      board.fill_burst();
      firmware.on_samples();
      break;
    case 4:
    case 5:
      board.make_edge(what - 4);
      return true;
    default:
      break;
  }
  firmware.poll();
  return true;
}

}  // namespace tetragauge
