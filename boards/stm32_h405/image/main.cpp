// SPDX-License-Identifier: Apache-2.0
// The image for the STM32-H405: the board, the controller on it, and the interrupts that join them.
#include "boards/cortex_m4/in_place.hpp"
#include "boards/cortex_m4/startup.hpp"
#include "boards/stm32_h405/interrupts.hpp"
#include "boards/stm32_h405/stm32_board.hpp"
#include "firmware/controller.hpp"

namespace tetragauge {
namespace {

using ImageBoard = Stm32Board<ChipBus, TETRAGAUGE_MIRRORS>;
using Firmware = Controller<ImageBoard>;
using OnInterrupt = Interrupts<ImageBoard, Firmware>;

// 'DFU!' here at reset: into the bootloader that is in the chip.
constexpr uint32_t kIntoBootloader = 0x4446'5521;
[[gnu::section(".keep")]] uint32_t reset_wish;
[[gnu::section(".keep")]] uint32_t boot_count;

void restart(bool into_bootloader) {
  reset_wish = into_bootloader ? kIntoBootloader : 0;
  reset_chip();
}

// Built in place, at their time and in their order.
constinit Place<ImageBoard> board = {};
constinit Place<Firmware> firmware = {};
// Something has happened that the main loop should look at.
volatile bool woken;

}  // namespace

// A reset stops the watchdog, so the bootloader has all the time it needs. AN2606, STM32F40xxx: system memory
// at 1FFF0000 begins with its stack and its start. From here the chip is as after a reset, which is what it
// needs.
void before_memory_is_ready() {
  using I = Io<ChipBus>;
  if (reset_wish == kIntoBootloader) {
    reset_wish = 0;
    rcc::switch_on<ChipBus>(rcc::kSyscfgOn(1));
    I::modify(syscfg::kMemMode(syscfg::kSystemFlashAtZero));
    ChipBus::barrier();
    const uint32_t stack = ChipBus::read(0x1FFF'0000), start = ChipBus::read(0x1FFF'0004);
    __asm__ volatile("msr msp, %0\n bx %1" ::"r"(stack), "r"(start));
  }
  // A bootloader that jumps here leaves its clocks, interrupts and memory map behind. A reset does not.
  if (!I::is(rcc::kSwitched(0))) reset_chip();
}

void stop_outputs() {
  pins::LaserOn::set<ChipBus>(false);
  pins::MotorsOn::set<ChipBus>(false);
}

void reset_chip() {
  Io<ChipBus>::write(core::kVectKey(core::kAircrKey) | core::kSysResetReq(1));
  ChipBus::barrier();
  for (;;) {
  }
}

namespace {

const char* name_of_crash(const Crash& crash) {
  switch (crash.exception) {
    case 3:
      return "the firmware has crashed (hard fault) and started again";
    case 4:
    case 5:
      return "the firmware has crashed (bus or memory fault) and started again";
    case 6:
      return "the firmware has crashed (usage fault) and started again";
    default:
      return "the firmware has crashed (unexpected interrupt) and started again";
  }
}

// The waits that have failed since `said`, at the start or later.
void say_what_failed(uint32_t* said) {
  const uint32_t failed = board->faults().bits();
  for (uint32_t k = 0; k < kWaitFaults && failed != *said; ++k) {
    if ((failed & ~*said) >> k & 1) firmware->log(tg_LogLevel_LOG_ERROR, name_of(static_cast<WaitFault>(k)));
  }
  *said = failed;
}

}  // namespace

void run_board() {
  new (InPlace{board.bytes}) ImageBoard({&boot_count, restart, stack_never_used_bytes});
  // Interrupts come from begin() on, and want the controller there.
  const uint32_t gate = ChipBus::close_gate();
  board->begin();
  new (InPlace{firmware.bytes}) Firmware(*board);
  ChipBus::open_gate(gate);
  firmware->begin();
  Crash crash;
  if (take_crash(&crash)) firmware->log(tg_LogLevel_LOG_ERROR, name_of_crash(crash));
  uint32_t said = 0;
  for (;;) {
    woken = false;
    say_what_failed(&said);
    firmware->poll();
    const uint32_t closed = ChipBus::close_gate();
    // An interrupt that came meanwhile ends the sleep at once; the next tick does in any case.
    if (!woken && board->now_ns() < firmware->next_poll_ns()) ChipBus::sleep();
    ChipBus::open_gate(closed);
  }
}

}  // namespace tetragauge

extern "C" {
using namespace tetragauge;

void Tick_Handler() {
  OnInterrupt::tick(*board);
  woken = true;
}
void Line_Handler() {
  OnInterrupt::line(*board);
  woken = true;
}
void LineOut_Handler() {
  OnInterrupt::line_out(*board);
  woken = true;
}
void Step_Handler() {
  OnInterrupt::step(*board, *firmware);
  woken = true;
}
void Interlock_Handler() {
  OnInterrupt::interlock(*board, *firmware);
  woken = true;
}
void Alarm_Handler() {
  OnInterrupt::alarm(*board, *firmware);
  woken = true;
}
void Samples_Handler() {
  OnInterrupt::samples(*board, *firmware);
  woken = true;
}
extern const Handler core_vectors[16];
[[gnu::section(".vectors.core"), gnu::used]] const Handler core_vectors[16] = {TETRAGAUGE_CORE_VECTORS};
}

namespace {
// RM0090 12.2, table 62.
struct InterruptVectors {
  Handler handler[82];
};
constexpr InterruptVectors vectors_of_board() {
  InterruptVectors vectors = {};
  for (Handler& handler : vectors.handler) handler = Crash_Handler;
  vectors.handler[usart1::kInterrupt] = Line_Handler;
  vectors.handler[dma2::interrupt_of(7)] = LineOut_Handler;
  vectors.handler[Tim2::kInterrupt] = Step_Handler;
  vectors.handler[Tim4::kInterrupt] = Interlock_Handler;
  vectors.handler[Tim5::kInterrupt] = Alarm_Handler;
  vectors.handler[dma2::interrupt_of(0)] = Samples_Handler;
  return vectors;
}
[[gnu::section(".vectors.interrupts"), gnu::used]] constexpr InterruptVectors interrupt_vectors =
    vectors_of_board();
}  // namespace
