// SPDX-License-Identifier: Apache-2.0
// Registers by their addresses, and what else a driver needs of the processor. Every member has its
// counterpart in a test's bus.
#pragma once

#include <cstdint>

namespace tetragauge {

struct ChipBus {
  static uint32_t read(uint32_t address) {
    return *reinterpret_cast<volatile uint32_t*>(static_cast<uintptr_t>(address));
  }
  static void write(uint32_t address, uint32_t value) {
    *reinterpret_cast<volatile uint32_t*>(static_cast<uintptr_t>(address)) = value;
  }
  // What a DMA controller is told of a buffer.
  static uint32_t address_of(const volatile void* memory) {
    return static_cast<uint32_t>(reinterpret_cast<uintptr_t>(memory));
  }
  // All that was written is there, and has had its effect, before anything after it; memory that DMA has
  // filled is read again.
  static void barrier() { __asm__ volatile("dsb\n isb" ::: "memory"); }

  // No interrupt between the two; nests.
  static uint32_t close_gate() {
    uint32_t primask = 0;
    __asm__ volatile("mrs %0, primask\n cpsid i" : "=r"(primask)::"memory");
    return primask;
  }
  static void open_gate(uint32_t primask) { __asm__ volatile("msr primask, %0" ::"r"(primask) : "memory"); }
  // Interrupts of that priority and below wait; 0: none does.
  static void hold_back(uint32_t priority) {
    __asm__ volatile("msr basepri, %0\n isb" ::"r"(priority << 4) : "memory");
  }
  // Until an interrupt is pending, be it held back or not.
  static void sleep() { __asm__ volatile("dsb\n wfi" ::: "memory"); }
};

// Holds every interrupt back in its scope.
template <class Bus>
class Gate {
 public:
  Gate() : before_(Bus::close_gate()) {}
  ~Gate() { Bus::open_gate(before_); }
  Gate(const Gate&) = delete;
  Gate& operator=(const Gate&) = delete;

 private:
  uint32_t before_;
};

}  // namespace tetragauge
