// SPDX-License-Identifier: Apache-2.0
// From reset to the board's own main(): FPU, memory, constructors. The board gives
//
//   void before_memory_is_ready();     // first of all, with the FPU on: touches no variable but those in
//   .keep
//   [[noreturn]] void run_board();     // the program
//   void stop_outputs();               // laser and motors, by registers alone; called from a fault
//   [[noreturn]] void reset_chip();
//
// and a vector table in section .vectors that begins with TETRAGAUGE_CORE_VECTORS.
#pragma once

#include <cstdint>

namespace tetragauge {

void before_memory_is_ready();
[[noreturn]] void run_board();
void stop_outputs();
[[noreturn]] void reset_chip();

using Handler = void (*)();

// Where the processor stood when it could not go on; kept over a reset.
struct Crash {
  static constexpr uint32_t kMagic = 0x4352'5348;
  uint32_t magic;
  uint32_t exception;  // number of the vector: 3 hard, 4 memory, 5 bus, 6 usage fault; others: an unexpected
                       // interrupt
  uint32_t pc, lr;
};
// The last one, if there was one since it was asked for.
bool take_crash(Crash* crash);

// Bytes of the stack that were never used since reset.
uint32_t stack_never_used_bytes();

}  // namespace tetragauge

extern "C" {
extern uint32_t tetragauge_stack_end[];  // image.ld
[[noreturn]] void Reset_Handler();
void Crash_Handler();
void Tick_Handler();  // SysTick; the board's
}

// Vectors 0 to 15 (Armv7-M, B1.5.2).
#define TETRAGAUGE_CORE_VECTORS                                                                       \
  reinterpret_cast<::tetragauge::Handler>(tetragauge_stack_end), Reset_Handler, Crash_Handler,        \
      Crash_Handler, Crash_Handler, Crash_Handler, Crash_Handler, nullptr, nullptr, nullptr, nullptr, \
      Crash_Handler, Crash_Handler, nullptr, Crash_Handler, Tick_Handler
