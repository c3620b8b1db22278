// SPDX-License-Identifier: Apache-2.0
// A bus for tests: registers are cells in memory that start with the chip's reset values, every write is kept
// by its register's name, and a test may say what the hardware does then.
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace tetragauge {

class RecordedBus {
 public:
  // RM0090 2.3 and the register maps at the end of each chapter, typed in for the tests alone.
  static std::string name_of(uint32_t address) {
    struct Peripheral {
      uint32_t base;
      const char* name;
      std::map<uint32_t, const char*> registers;
    };
    static const std::map<uint32_t, const char*> timer = {
        {0x00, "CR1"},   {0x04, "CR2"},   {0x0C, "DIER"}, {0x10, "SR"},   {0x14, "EGR"},
        {0x18, "CCMR1"}, {0x1C, "CCMR2"}, {0x20, "CCER"}, {0x24, "CNT"},  {0x28, "PSC"},
        {0x2C, "ARR"},   {0x30, "RCR"},   {0x34, "CCR1"}, {0x3C, "CCR3"}, {0x40, "CCR4"}};
    static const std::map<uint32_t, const char*> port = {{0x00, "MODER"}, {0x08, "OSPEEDR"}, {0x0C, "PUPDR"},
                                                         {0x18, "BSRR"},  {0x20, "AFRL"},    {0x24, "AFRH"}};
    static const std::map<uint32_t, const char*> converter = {
        {0x00, "SR"},    {0x04, "CR1"},  {0x08, "CR2"},  {0x0C, "SMPR1"},
        {0x10, "SMPR2"}, {0x2C, "SQR1"}, {0x30, "SQR2"}, {0x34, "SQR3"}};
    static const Peripheral kChip[] = {
        {0x40000000, "TIM2", timer},
        {0x40000800, "TIM4", timer},
        {0x40000C00, "TIM5", timer},
        {0x40010400, "TIM8", timer},
        {0x40003000, "IWDG", {{0x0, "KR"}, {0x4, "PR"}, {0x8, "RLR"}, {0xC, "SR"}}},
        {0x40003800, "SPI2", {{0x0, "CR1"}, {0x8, "SR"}, {0xC, "DR"}}},
        {0x40007000, "PWR", {{0x0, "CR"}}},
        {0x40007400, "DAC", {{0x00, "CR"}, {0x20, "DHR12RD"}}},
        {0x40011000, "USART1", {{0x0, "SR"}, {0x4, "DR"}, {0x8, "BRR"}, {0xC, "CR1"}, {0x14, "CR3"}}},
        {0x40012000, "ADC1", converter},
        {0x40012100, "ADC2", converter},
        {0x40012300, "ADC", {{0x4, "CCR"}, {0x8, "CDR"}}},
        {0x40020000, "GPIOA", port},
        {0x40020400, "GPIOB", port},
        {0x40020800, "GPIOC", port},
        {0x40023800,
         "RCC",
         {{0x00, "CR"},
          {0x04, "PLLCFGR"},
          {0x08, "CFGR"},
          {0x30, "AHB1ENR"},
          {0x34, "AHB2ENR"},
          {0x40, "APB1ENR"},
          {0x44, "APB2ENR"},
          {0x74, "CSR"}}},
        {0x40023C00, "FLASH", {{0x00, "ACR"}, {0x04, "KEYR"}, {0x0C, "SR"}, {0x10, "CR"}}},
        {0x50060800, "RNG", {{0x0, "CR"}, {0x4, "SR"}, {0x8, "DR"}}},
    };
    for (const Peripheral& peripheral : kChip) {
      const auto found = peripheral.registers.find(address - peripheral.base);
      if (address >= peripheral.base && found != peripheral.registers.end())
        return std::string(peripheral.name) + "_" + found->second;
    }
    static const char* const kDma[] = {"LISR", "HISR", "LIFCR", "HIFCR"};
    static const char* const kStream[] = {"CR", "NDTR", "PAR", "M0AR", "M1AR", "FCR"};
    const uint32_t dma = address - 0x40026400;
    if (dma < 0x10) return std::string("DMA2_") + kDma[dma / 4];
    if (dma < 0xD0) return "DMA2_S" + std::to_string((dma - 0x10) / 0x18) + kStream[(dma - 0x10) % 0x18 / 4];
    return text("%08X", address);
  }

  // All as after a reset (the registers that do not begin as 0).
  static void reset() {
    cells = {{0x40023800, 0x0000'0083}, {0x40023804, 0x2400'3010}, {0x40023830, 0x0010'0000},
             {0x40007000, 0x0000'4000}, {0x40023C10, 0x8000'0000}, {0x40020000, 0xA800'0000},
             {0x40020008, 0x0C00'0000}, {0x4002000C, 0x6400'0000}, {0x40020400, 0x0000'0280},
             {0x40020408, 0x0000'00C0}, {0x4002040C, 0x0000'0100}, {0x40011000, 0x0000'00C0},
             {0x40003808, 0x0000'0002}};
    writes.clear();
    on_write = [](uint32_t, uint32_t) {};
    on_read = [](uint32_t) {};
    memory.clear();
    gates = 0;
  }

  static uint32_t read(uint32_t address) {
    on_read(address);
    return cells[address];
  }
  static void write(uint32_t address, uint32_t value) {
    writes.push_back(name_of(address) + " = " + text("%08X", value));
    cells[address] = value;
    on_write(address, value);
  }
  // Memory as the chip sees it: a number for each place that a driver has named.
  static uint32_t address_of(const volatile void* place) {
    for (size_t k = 0; k < memory.size(); ++k) {
      if (memory[k] == place) return 0x2000'0000 + 0x1'0000 * static_cast<uint32_t>(k);
    }
    memory.push_back(place);
    return address_of(place);
  }
  static void barrier() {}
  static uint32_t close_gate() { return gates++; }
  static void open_gate(uint32_t before) { gates = before; }
  static void hold_back(uint32_t) {}
  static void sleep() {}

  // What was written since the last time.
  static std::vector<std::string> take_writes() {
    std::vector<std::string> taken;
    taken.swap(writes);
    return taken;
  }

  static inline std::map<uint32_t, uint32_t> cells;
  static inline std::vector<std::string> writes;
  static inline std::function<void(uint32_t address, uint32_t value)> on_write;
  static inline std::function<void(uint32_t address)> on_read;
  static inline std::vector<const volatile void*> memory;
  static inline uint32_t gates = 0;

 private:
  static std::string text(const char* format, uint32_t number) {
    char bytes[16];
    std::snprintf(bytes, sizeof bytes, format, number);
    return bytes;
  }
};

}  // namespace tetragauge
