// SPDX-License-Identifier: Apache-2.0
// The controller on a board that is nothing but memory cells, to be compiled for a Cortex-M4F: what the
// portable core needs, and nothing else, must link.
#include "firmware/controller.hpp"
#include "firmware/hal/memory_storage.hpp"

namespace tetragauge {
namespace {

volatile uint32_t cells[21];
MemoryStorage store;

struct StubBoard {
  static constexpr const char* kName = "stub";
  static constexpr uint32_t kCapabilities = 0;
  static constexpr uint32_t kSamplePeriodNs = 10'000;
  static constexpr int32_t kMirrorCodeStep = 1;
  static constexpr int32_t kMirrorReachUrad = 32'767 * kUradPerMirrorCode;

  uint32_t boot_id() const { return cells[0]; }
  uint64_t now_ns() const { return uint64_t{cells[1]} * 1000; }
  void set_alarm_ns(uint64_t time_ns) { cells[2] = static_cast<uint32_t>(time_ns / 1000); }
  void set_mirrors(int16_t a, int16_t b) { cells[3] = static_cast<uint32_t>(a * 65'536 + b); }
  void set_laser(bool on) { cells[4] = on; }
  void start_samples(PsdSample* samples, uint32_t count) {
    burst = samples;
    cells[5] = count;
  }
  static constexpr uint32_t kStepTicksPerSecond = 84'000'000;
  uint64_t step_clock() const { return (uint64_t{cells[9]} << 32) | cells[8]; }
  bool schedule_step(Axis axis, uint64_t tick, int direction) {
    cells[20] = static_cast<uint32_t>(direction);
    cells[6 + static_cast<int>(axis)] = static_cast<uint32_t>(tick);
    return static_cast<int32_t>(static_cast<uint32_t>(tick) - cells[8]) > 0;
  }
  bool cancel_step(Axis axis) { return cells[6 + static_cast<int>(axis)] != 0; }
  uint32_t inputs() const { return cells[10]; }
  size_t read(uint8_t* bytes, size_t capacity) {
    size_t count = 0;
    while (count < capacity && cells[11] != 0) bytes[count++] = static_cast<uint8_t>(cells[12]);
    return count;
  }
  size_t write(const uint8_t* bytes, size_t count) {
    for (size_t i = 0; i < count; ++i) cells[13] = bytes[i];
    return count;
  }
  void mask_interrupts(bool on) { cells[14] = on; }
  void kick_watchdog() { cells[15] = 0; }
  Storage& storage() { return store; }
  tg_ResetCause reset_cause() const { return static_cast<tg_ResetCause>(cells[16]); }
  void restart(bool into_bootloader) { cells[17] = into_bootloader; }
  uint32_t stack_free_bytes() const { return cells[18]; }
  bool self_check(tg_SelfTestCheck check, tg_SelfTestItem* item) {
    item->value = static_cast<int32_t>(cells[19]);
    return check == tg_SelfTestCheck_CHECK_CLOCK;
  }

  PsdSample* burst = nullptr;
};

StubBoard board;
constinit unsigned char memory[sizeof(Controller<StubBoard>)] __attribute__((aligned(8))) = {};

// No <new>: constructed in place, as a chip's start-up code does.
struct InPlace {
  unsigned char* at;
};

}  // namespace
}  // namespace tetragauge

void* operator new(size_t, tetragauge::InPlace place) noexcept {
  return place.at;
}

namespace {
tetragauge::Controller<tetragauge::StubBoard>* controller;
}

// The interrupts, by priority from low to high: functions of their own, so that each one's stack can be told.
extern "C" {
void Alarm_Handler() {
  controller->on_alarm();
}
void Samples_Handler() {
  controller->on_samples();
}
void Interlock_Handler() {
  controller->on_interlock();
}
void Step_Handler() {
  controller->on_step_timer(tetragauge::Axis::kTable);
}
// In flash at the places the processor looks for them; here only kept by the linker.
using Handler = void (*)();
extern const Handler handlers[];
[[gnu::used]] const Handler handlers[] = {Alarm_Handler, Samples_Handler, Interlock_Handler, Step_Handler};
}

extern "C" [[noreturn]] void Reset_Handler() {
  using namespace tetragauge;
  controller = new (InPlace{memory}) Controller<StubBoard>(board);
  controller->begin();
  for (;;) {
    controller->poll();
    if (handlers[cells[0] % 4] == nullptr) continue;
    cells[1] = static_cast<uint32_t>(controller->next_poll_ns() / 1000) + controller->resting();
  }
}
