// SPDX-License-Identifier: GPL-3.0-or-later
// What the firmware's work costs in instructions of a Cortex-M4F: QEMU with `-icount shift=3` takes 8 ns of
// virtual time for each, which the board's timers count at 25 MHz. And how late a step's interrupt comes
// while points are made. One line each: what, instructions.
#include <cstdio>
#include <initializer_list>

#include "firmware/link/stream_ring.hpp"
#include "firmware/machine_config.hpp"
#include "firmware/measure/judge_ray.hpp"
#include "firmware/motion/move_times.hpp"
#include "firmware/optics/galvo.hpp"
#include "firmware/optics/psd_camera.hpp"

namespace tetragauge {
namespace {

constexpr uint32_t kInstructionsPerTick = 5;
volatile uint32_t& word_at(uint32_t address) {
  return *reinterpret_cast<volatile uint32_t*>(address);
}

// CMSDK APB timers (Arm DDI 0479): 0 counts instructions, 1 is no device of the scan's, 0 and 1 then make
// steps.
struct Timer {
  uint32_t base, interrupt;
  void run(uint32_t reload, bool interrupts) const {
    word_at(base) = 0;
    word_at(base + 8) = reload;
    word_at(base + 4) = reload;
    word_at(base + 12) = 1;
    word_at(base) = interrupts ? 9 : 1;
  }
  uint32_t value() const { return word_at(base + 4); }
};
constexpr Timer kTimers[] = {{0x40000000, 8}, {0x40001000, 9}};

class Count {
 public:
  Count() { kTimers[0].run(~0u, false); }
  uint32_t instructions() const { return (~0u - kTimers[0].value()) * kInstructionsPerTick; }
};

uint32_t seed = 1;
uint32_t draw(uint32_t below) {
  seed = seed * 1664525u + 1013904223u;  // Numerical Recipes
  return (seed >> 8) % below;
}

const MachineConfig config = nominal_config();
const auto truth = geometry_of<double>(config);
const auto machine = geometry_of<MachineScalar>(config);
constexpr StagePlace kStage{0.7f, 150};

struct Burst {
  PsdSample sample[kBurstSamples];
};

// A raster of 1 mm over a rough wall 350 mm away, seen by both cameras.
RayPlace aim(uint32_t ray, DetectorPosition<double> (&at)[2]) {
  const auto step = [](uint32_t k) { return static_cast<int32_t>(k) * 1429 - 50'000; };
  const RayPlace place{0, ray, step(ray % 70), step(ray / 70), true};
  const Beam<double> beam = beam_from_mirrors(truth.galvo, place.a_urad * 1e-6, place.b_urad * 1e-6);
  const Vector3<double> spot = beam.origin + beam.direction * (350 + draw(100) * 1e-3);
  for (int c = 0; c < 2; ++c) {
    bool in_view = false;
    at[c] = project(truth.camera[c], spot, &in_view);
  }
  return place;
}
void expose(const DetectorPosition<double> (&at)[2], double current, uint32_t count, Burst* burst) {
  for (uint32_t i = 0; i < count; ++i) {
    for (int c = 0; c < 2; ++c) {
      const double half = truth.camera[c].half_size_mm;
      const auto code = [&](double share) {
        return static_cast<int16_t>(300 + current * share + static_cast<double>(draw(1'000)) / 200);
      };
      burst->sample[i].camera[c] = {code(0.5 - at[c].x_mm / half / 2), code(0.5 + at[c].x_mm / half / 2),
                                    code(0.5 - at[c].y_mm / half / 2), code(0.5 + at[c].y_mm / half / 2)};
    }
  }
}

void say(const char* what, double instructions) {
  std::printf("%s,%.0f\n", what, instructions);
}

StreamRing ring;
tg_MachineMessage message;
BatchBuilder builder;
uint8_t wire[kFrameWireBytes];
uint32_t wire_bytes;

// What a full batch costs on its way out, with its ring slot and its frame.
void send_batch() {
  message = tg_MachineMessage_init_zero;
  message.which_body = tg_MachineMessage_points_tag;
  message.body.points = builder.batch();
  if (ring.full()) ring.credit({1, ring.next_item(), ring.next_item() + 1});
  const uint32_t item = ring.next_item();
  ring.push(message);
  wire_bytes += static_cast<uint32_t>(ring.encode(item, wire));
  builder.start(1, 0, 0, 150'000);
}

void count_points(uint32_t samples) {
  constexpr uint32_t kRays = 480;
  static Burst bursts[3];
  uint64_t averaging = 0, judging = 0, packing = 0;
  uint32_t points = 0, crc = 0;
  ring.start(1);
  builder.start(1, 0, 0, 150'000);
  wire_bytes = 0;
  for (uint32_t ray = 0; ray < kRays; ++ray) {
    DetectorPosition<double> at[2];
    const RayPlace place = aim(ray, at);
    expose(at, 0, samples / 2, &bursts[0]);
    expose(at, 4'000, samples, &bursts[1]);
    expose(at, 0, samples / 2, &bursts[2]);
    RaySamples kept;
    const Count average;
    kept.add(Light::kOffBefore, bursts[0].sample, samples / 2, 32'700, config.measure.trim_permille);
    kept.add(Light::kOn, bursts[1].sample, samples, 32'700, config.measure.trim_permille);
    kept.add(Light::kOffAfter, bursts[2].sample, samples / 2, 32'700, config.measure.trim_permille);
    averaging += average.instructions();
    const Count judge;
    const BeamRecord record = judge_ray(machine, config.measure, kStage, place, kept);
    judging += judge.instructions();
    points += record.reason == 0;
    const Count pack;
    if (!builder.add(record)) {
      send_batch();
      builder.add(record);
    }
    crc = crc_of_beam(record, crc);
    packing += pack.instructions();
  }
  const Count last;
  send_batch();
  packing += last.instructions();
  char what[64];
  std::snprintf(what, sizeof what, "averaging at %lu samples", static_cast<unsigned long>(samples));
  say(what, static_cast<double>(averaging) / kRays);
  if (samples != 36) return;
  std::printf("points of %lu rays,%lu\n", static_cast<unsigned long>(kRays),
              static_cast<unsigned long>(points));
  say("optics solve and judgement", static_cast<double>(judging) / kRays);
  say("encode + CRC + COBS", static_cast<double>(packing) / kRays);
  std::printf("bytes on the wire,%.2f\n", static_cast<double>(wire_bytes) / points);
}

// ---------------------------------------------------------------- steps

struct Stepping {
  MoveTimes move;
  uint32_t steps = 0, latest_ticks = 0, longest_ticks = 0;
} stepping[2];
constexpr uint32_t kStepTicks = 125;  // 5 us: 200 kHz

// The interrupt comes at 0, the counter begins again one tick later.
uint32_t since_edge(const Timer& timer) {
  return (kStepTicks - timer.value()) % kStepTicks;
}

void on_step(int axis) {
  Stepping& s = stepping[axis];
  const Timer& timer = kTimers[axis];
  const uint32_t late = since_edge(timer);
  word_at(timer.base + 12) = 1;
  if (s.move.given() < s.move.steps()) s.move.next();
  ++s.steps;
  const uint32_t done = since_edge(timer);
  if (late > s.latest_ticks) s.latest_ticks = late;
  if (done > s.longest_ticks) s.longest_ticks = done;
}

// From step `first` of a move, `steps` of them, all at the speed of the move's middle.
void count_step_latency(const char* when, uint32_t first, uint32_t steps) {
  stepping[0] = stepping[1] = {};
  for (int axis = 0; axis < 2; ++axis) {
    MoveTimes& move = stepping[axis].move;
    move.plan(200'000, {200'000, 4'000'000, 100'000'000}, 25'000'000);
    while (move.given() < first) move.next();
  }
  for (int axis = 0; axis < 2; ++axis) {
    kTimers[axis].run(kStepTicks - 1, true);
    word_at(0xE000E100) = 1u << kTimers[axis].interrupt;
  }
  // As the main loop does while points stream: judge, pack, frame.
  static Burst burst;
  DetectorPosition<double> at[2];
  const RayPlace place = aim(0, at);
  expose(at, 4'000, 36, &burst);
  uint32_t crc = 0;
  for (uint32_t ray = 0; stepping[0].steps < steps; ++ray) {
    RaySamples kept;
    for (const Light light : {Light::kOffBefore, Light::kOn, Light::kOffAfter})
      kept.add(light, burst.sample, 36, 32'700, config.measure.trim_permille);
    BeamRecord record = judge_ray(machine, config.measure, kStage, place, kept);
    record.ray = ray;
    if (!builder.add(record)) {
      send_batch();
      builder.add(record);
    }
    crc = crc_of_beam(record, crc);
  }
  for (const Timer& timer : kTimers) word_at(timer.base) = 0;
  const Stepping &a = stepping[0], &b = stepping[1];
  const uint32_t late = a.latest_ticks > b.latest_ticks ? a.latest_ticks : b.latest_ticks;
  const uint32_t ready = a.longest_ticks > b.longest_ticks ? a.longest_ticks : b.longest_ticks;
  char what[100];
  std::snprintf(what, sizeof what, "step interrupt begins after the edge, both axes %s, worst", when);
  say(what, late * kInstructionsPerTick);
  std::snprintf(what, sizeof what, "next step is ready after the edge, both axes %s, worst", when);
  say(what, ready * kInstructionsPerTick);
}

}  // namespace
}  // namespace tetragauge

extern "C" {
void Timer0_Handler() {
  tetragauge::on_step(0);
}
void Timer1_Handler() {
  tetragauge::on_step(1);
}
}

int main() {
  std::printf("what,instructions\n");
  for (const uint32_t samples : {4, 8, 16, 36}) tetragauge::count_points(samples);
  // A move has sped up to 200 kHz after 9,000 steps; with its arithmetic from step 4,000 on, and at speed.
  tetragauge::count_step_latency("speeding up", 4'000, 4'500);
  tetragauge::count_step_latency("at 200 kHz", 50'000, 20'000);
  std::fflush(stdout);
}
