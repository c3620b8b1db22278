// SPDX-License-Identifier: Apache-2.0
#include "boards/cortex_m4/startup.hpp"

extern "C" {
// Places that sections.ld names.
extern uint32_t tetragauge_stack_begin[];
extern const uint32_t tetragauge_data_load[];
extern uint32_t tetragauge_data_begin[], tetragauge_data_end[];
extern uint32_t tetragauge_bss_begin[], tetragauge_bss_end[];
extern void (*const tetragauge_init_begin[])();
extern void (*const tetragauge_init_end[])();
[[noreturn]] void tetragauge_start();
[[noreturn]] void tetragauge_crash(const uint32_t* frame, uint32_t exception);
}

namespace tetragauge {
namespace {

constexpr uint32_t kNeverUsed = 0xA5A5'A5A5;
[[gnu::section(".keep")]] Crash last_crash;

}  // namespace

bool take_crash(Crash* crash) {
  if (last_crash.magic != Crash::kMagic) return false;
  *crash = last_crash;
  last_crash.magic = 0;
  return true;
}

uint32_t stack_never_used_bytes() {
  const uint32_t* at = tetragauge_stack_begin;
  while (at < tetragauge_stack_end && *at == kNeverUsed) ++at;
  return static_cast<uint32_t>(at - tetragauge_stack_begin) * 4;
}

}  // namespace tetragauge

extern "C" {

// The FPU (CPACR, Armv7-M B3.2.20) before anything the compiler may use it for.
[[gnu::naked]] void Reset_Handler() {
  __asm__ volatile(
      "ldr r0, =0xE000ED88\n"
      "ldr r1, [r0]\n"
      "orr r1, r1, #(0xF << 20)\n"
      "str r1, [r0]\n"
      "dsb\n"
      "isb\n"
      "b tetragauge_start\n");
}

void tetragauge_start() {
  tetragauge::before_memory_is_ready();
  // This function's own frame lies on top of what is painted.
  auto* const frame = static_cast<volatile uint32_t*>(__builtin_frame_address(0));
  for (volatile uint32_t* at = tetragauge_stack_begin; at < frame - 64; ++at) *at = tetragauge::kNeverUsed;
  const uint32_t* from = tetragauge_data_load;
  for (volatile uint32_t* to = tetragauge_data_begin; to < tetragauge_data_end;) *to++ = *from++;
  for (volatile uint32_t* to = tetragauge_bss_begin; to < tetragauge_bss_end;) *to++ = 0;
  for (auto init = tetragauge_init_begin; init < tetragauge_init_end; ++init) (*init)();
  tetragauge::run_board();
}

// Where the stack has run out, the last words are told from its top again.
[[gnu::naked]] void Crash_Handler() {
  __asm__ volatile(
      "mov r0, sp\n"
      "mrs r1, ipsr\n"
      "ldr r2, =tetragauge_stack_begin\n"
      "add r2, r2, #256\n"
      "cmp r0, r2\n"
      "bhs 1f\n"
      "ldr r2, =tetragauge_stack_end\n"
      "mov sp, r2\n"
      "1: b tetragauge_crash\n");
}

// Frame: r0 r1 r2 r3 r12 lr pc xpsr (B1.5.6). The outputs first: a stack that ran over gives no good frame.
void tetragauge_crash(const uint32_t* frame, uint32_t exception) {
  tetragauge::stop_outputs();
  const bool on_stack = frame >= tetragauge_stack_begin && frame + 8 <= tetragauge_stack_end;
  tetragauge::last_crash = {tetragauge::Crash::kMagic, exception, on_stack ? frame[6] : 0,
                            on_stack ? frame[5] : 0};
  tetragauge::reset_chip();
}

// Constructors of static objects register their destructors; nothing here ever ends.
int __aeabi_atexit(void*, void (*)(void*), void*) {
  return 0;
}
void* __dso_handle = nullptr;
}
