// SPDX-License-Identifier: GPL-3.0-or-later
// From reset to newlib's start-up code, which finds heap and stack by semihosting and calls main().
#include <cstdint>

extern "C" {
[[noreturn]] void _start();

[[noreturn]] void Reset_Handler() {
  // The FPU (CPACR, Armv7-M B3.2.20) before anything the compiler may use it for.
  *reinterpret_cast<volatile uint32_t*>(0xE000ED88u) |= 0xFu << 20;
  __asm__ volatile("dsb\nisb" ::: "memory");
  _start();
}
void Fault_Handler();

// Of a program that uses them.
[[gnu::weak, gnu::nothrow, gnu::alias("Fault_Handler")]] void Timer0_Handler();
[[gnu::weak, gnu::nothrow, gnu::alias("Fault_Handler")]] void Timer1_Handler();

// gtest would make a folder for a report in XML, which nobody asks for here.
int mkdir(const char*, unsigned);
int mkdir(const char*, unsigned) {
  return -1;
}
}

// Says so and ends QEMU: SYS_WRITE0, SYS_EXIT with ADP_Stopped_RunTimeErrorUnknown.
extern "C" [[gnu::naked]] void Fault_Handler() {
  __asm__ volatile(
      "movs r0, #4\n ldr r1, =fault_text\n bkpt 0xab\n"
      "movs r0, #0x18\n ldr r1, =0x20023\n bkpt 0xab\n b .\n");
}

extern "C" {
extern const char fault_text[];
[[gnu::used]] const char fault_text[] = "fault: the processor cannot go on\n";

using Handler = void (*)();
// Exceptions 1 to 15, then the board's interrupts (Arm DAI 0386, table 3-12).
struct Vectors {
  uint32_t stack_end = 0x22000000;
  Handler handler[47] = {};
};
constexpr Vectors vectors_of_tests() {
  Vectors vectors;
  for (Handler& handler : vectors.handler) handler = Fault_Handler;
  vectors.handler[0] = Reset_Handler;
  vectors.handler[15 + 8] = Timer0_Handler;
  vectors.handler[15 + 9] = Timer1_Handler;
  return vectors;
}
extern const Vectors vectors;
[[gnu::section(".vectors.tests"), gnu::used]] constexpr Vectors vectors = vectors_of_tests();
}
