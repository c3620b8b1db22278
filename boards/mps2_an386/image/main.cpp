// SPDX-License-Identifier: Apache-2.0
// The image for QEMU's mps2-an386: the firmware measures in a simulated world on the other end of two FIFOs.
// What comes from there pends the processor's own interrupts, so that each runs in its own context as on a
// chip.
#include "boards/cortex_m4/chip_bus.hpp"
#include "boards/cortex_m4/core.hpp"
#include "boards/cortex_m4/in_place.hpp"
#include "boards/cortex_m4/startup.hpp"
#include "boards/mps2_an386/fifo_board.hpp"
#include "firmware/controller.hpp"

namespace tetragauge {
namespace {

using ImageBoard = FifoBoard<ChipBus>;
using Firmware = Controller<ImageBoard>;
using mps2_bus::Call;

constinit Place<ImageBoard> board = {};
constinit Place<Firmware> firmware = {};
Axis due_axis;

// Of the board's 32, numbers that none of its devices has (Arm DAI 0386, table 3-12).
constexpr uint32_t kStepInterrupt = 28, kInterlockInterrupt = 29, kAlarmInterrupt = 30,
                   kSamplesInterrupt = 31;
constexpr uint32_t kStepPriority = 1, kInterlockPriority = 2, kMeasurePriority = 3;

void interrupt(Call call) {
  switch (call) {
    case Call::table_step:
    case Call::slide_step:
      due_axis = call == Call::table_step ? Axis::kTable : Axis::kSlide;
      core::pend_interrupt<ChipBus, kStepInterrupt>();
      break;
    case Call::interlock:
      core::pend_interrupt<ChipBus, kInterlockInterrupt>();
      break;
    case Call::alarm:
      core::pend_interrupt<ChipBus, kAlarmInterrupt>();
      break;
    case Call::samples:
      core::pend_interrupt<ChipBus, kSamplesInterrupt>();
      break;
    default:
      break;
  }
}

void put_hex(char* at, uint32_t number) {
  for (int digit = 7; digit >= 0; --digit, number >>= 4) at[digit] = "0123456789abcdef"[number & 15];
}

}  // namespace

void before_memory_is_ready() {}
void stop_outputs() {}  // the world switches its laser off with its program
void reset_chip() {
  static char said[] = "the firmware has crashed at 00000000, called from 00000000\n";
  Crash crash = {};
  take_crash(&crash);
  put_hex(said + 28, crash.pc);
  put_hex(said + 50, crash.lr);
  FifoLink<ChipBus>::fail(said);
}

void run_board() {
  core::enable_interrupt<ChipBus, kStepInterrupt>(kStepPriority);
  core::enable_interrupt<ChipBus, kInterlockInterrupt>(kInterlockPriority);
  core::enable_interrupt<ChipBus, kAlarmInterrupt>(kMeasurePriority);
  core::enable_interrupt<ChipBus, kSamplesInterrupt>(kMeasurePriority);
  new (InPlace{board.bytes}) ImageBoard;
  board->begin();
  for (;;) {
    const Call call = board->next_call();
    if (call == Call::start) {
      new (InPlace{firmware.bytes}) Firmware(*board);
      firmware->begin();
    } else {
      interrupt(call);
      firmware->poll();
    }
    board->finish({.resting = firmware->resting(),
                   .state = static_cast<uint32_t>(firmware->state()),
                   .fault = static_cast<uint32_t>(firmware->fault()),
                   .view = firmware->view(),
                   .next_poll_ns = firmware->next_poll_ns()});
  }
}

}  // namespace tetragauge

extern "C" {
using namespace tetragauge;

void Tick_Handler() {}
void Step_Handler() {
  firmware->on_step_timer(due_axis);
}
void Interlock_Handler() {
  firmware->on_interlock();
}
void Alarm_Handler() {
  firmware->on_alarm();
}
void Samples_Handler() {
  firmware->on_samples();
}
extern const Handler core_vectors[16];
[[gnu::section(".vectors.core"), gnu::used]] const Handler core_vectors[16] = {TETRAGAUGE_CORE_VECTORS};
}

namespace {
struct InterruptVectors {
  Handler handler[32];
};
constexpr InterruptVectors vectors_of_board() {
  InterruptVectors vectors = {};
  for (Handler& handler : vectors.handler) handler = Crash_Handler;
  vectors.handler[kStepInterrupt] = Step_Handler;
  vectors.handler[kInterlockInterrupt] = Interlock_Handler;
  vectors.handler[kAlarmInterrupt] = Alarm_Handler;
  vectors.handler[kSamplesInterrupt] = Samples_Handler;
  return vectors;
}
[[gnu::section(".vectors.interrupts"), gnu::used]] constexpr InterruptVectors interrupt_vectors =
    vectors_of_board();
}  // namespace
