// SPDX-License-Identifier: Apache-2.0
// Two banks of memory that keep their words without power. Flash rules: erasing a bank sets all of its words
// to kErasedWord, a write programs words that are erased. A cut of power spoils at most the word being
// written, or the bank being erased. On some chips an erasure stalls the processor (STM32F405: 1 to 2 s for a
// sector of 128 KB): the controller asks for it only with the laser off and the stage at rest.
#pragma once

#include <cstdint>

namespace tetragauge {

class Storage {
 public:
  static constexpr uint32_t kBanks = 2;
  static constexpr uint32_t kErasedWord = 0xFFFFFFFF;

  virtual uint32_t bank_words() const = 0;
  // These start the operation; false when it cannot be started, or the last one has failed. busy() until it
  // is over.
  virtual bool erase(uint32_t bank) = 0;
  virtual bool write(uint32_t bank, uint32_t first_word, const uint32_t* words, uint32_t count) = 0;
  virtual bool busy() const = 0;
  // Not while busy.
  virtual void read(uint32_t bank, uint32_t first_word, uint32_t* words, uint32_t count) const = 0;

 protected:
  ~Storage() = default;
};

}  // namespace tetragauge
