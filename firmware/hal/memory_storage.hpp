// SPDX-License-Identifier: Apache-2.0
// A store in memory, for boards and tests without one that lasts: words as a flash memory keeps them.
#pragma once

#include "firmware/hal/storage.hpp"

namespace tetragauge {

class MemoryStorage : public Storage {
 public:
  static constexpr uint32_t kBankWords = 1024;

  MemoryStorage() {
    for (auto& bank : words) {
      for (uint32_t& word : bank) word = kErasedWord;
    }
  }
  uint32_t bank_words() const override { return kBankWords; }
  bool erase(uint32_t bank) override {
    for (uint32_t& word : words[bank]) word = kErasedWord;
    return true;
  }
  bool write(uint32_t bank, uint32_t first_word, const uint32_t* from, uint32_t count) override {
    // Programming only clears bits: what was not erased before does not become what was asked for.
    for (uint32_t i = 0; i < count; ++i) words[bank][first_word + i] &= from[i];
    return true;
  }
  bool busy() const override { return false; }
  void read(uint32_t bank, uint32_t first_word, uint32_t* to, uint32_t count) const override {
    for (uint32_t i = 0; i < count; ++i) to[i] = words[bank][first_word + i];
  }

  uint32_t words[kBanks][kBankWords];
};

}  // namespace tetragauge
