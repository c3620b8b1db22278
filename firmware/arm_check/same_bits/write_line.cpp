// SPDX-License-Identifier: Apache-2.0
// Text out and start-up: of the host by its C library, of a bare Cortex-M4F under QEMU by semihosting.
#ifndef __arm__
#include <cstdio>

void say(const char* text);
void say(const char* text) {
  std::fputs(text, stdout);
}
#else
#include <cstdint>

int main();
void say(const char* text);

namespace {
// Arm's "Semihosting for AArch32 and AArch64", 2.0: SYS_WRITE0 is 4, SYS_EXIT 0x18 with
// ADP_Stopped_ApplicationExit.
void semihosting(uint32_t operation, const void* argument) {
  register uint32_t r0 __asm__("r0") = operation;
  register const void* r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}
}  // namespace

void say(const char* text) {
  semihosting(4, text);
}

extern "C" [[noreturn]] void Reset_Handler() {
  // The FPU first, then anything that uses it. There is no initialised data but constants (checked by the
  // script).
  *reinterpret_cast<volatile uint32_t*>(0xE000ED88u) |= 0xFu << 20;
  __asm__ volatile("dsb\nisb" ::: "memory");
  main();
  semihosting(0x18, reinterpret_cast<const void*>(0x20026u));
  for (;;) {
  }
}

extern "C" const void* const vectors[] __attribute__((section(".vectors"), used)) = {
    reinterpret_cast<const void*>(0x20400000u), reinterpret_cast<const void*>(Reset_Handler)};
#endif
