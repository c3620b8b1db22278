// SPDX-License-Identifier: Apache-2.0
// Files of the computer that an emulator of the chip runs on. Arm, "Semihosting for AArch32 and
// AArch64", 2.0.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tetragauge::semihosting {

inline uint32_t call(uint32_t operation, const void* argument) {
  register uint32_t r0 __asm__("r0") = operation;
  register const void* r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

constexpr size_t length_of(const char* text) {
  size_t n = 0;
  while (text[n] != '\0') ++n;
  return n;
}

// Modes as fopen's, numbered: "rb" 1, "wb" 5. -1: it cannot be opened.
enum class Mode : uint32_t { read = 1, write = 5 };
inline int32_t open(const char* path, Mode mode) {
  const uint32_t block[] = {reinterpret_cast<uintptr_t>(path), static_cast<uint32_t>(mode), length_of(path)};
  return static_cast<int32_t>(call(0x01, block));
}

// Bytes read; 0 at the end of the file.
inline size_t read(int32_t file, void* bytes, size_t count) {
  const uint32_t block[] = {static_cast<uint32_t>(file), reinterpret_cast<uintptr_t>(bytes), count};
  const uint32_t not_read = call(0x06, block);
  return not_read > count ? 0 : count - not_read;
}

// True when all of them are written.
inline bool write(int32_t file, const void* bytes, size_t count) {
  const uint32_t block[] = {static_cast<uint32_t>(file), reinterpret_cast<uintptr_t>(bytes), count};
  return call(0x05, block) == 0;
}

inline void say(const char* text) {
  call(0x04, text);
}

// Ends the emulator: ADP_Stopped_ApplicationExit, or ADP_Stopped_RunTimeErrorUnknown for a failure.
[[noreturn]] inline void exit(bool good) {
  call(0x18, reinterpret_cast<const void*>(good ? 0x20026u : 0x20023u));
  for (;;) {
  }
}

}  // namespace tetragauge::semihosting
