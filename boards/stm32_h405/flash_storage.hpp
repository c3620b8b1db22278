// SPDX-License-Identifier: Apache-2.0
// The calibration's two banks: the last two sectors of the flash, 128 KB each, far from the image at its
// beginning. RM0090 3.6. An erasure stalls the processor, which runs from the same flash, for 1 to 2 s.
#pragma once

#include "boards/cortex_m4/chip_bus.hpp"
#include "boards/stm32_h405/registers/flash.hpp"
#include "boards/stm32_h405/waits.hpp"
#include "firmware/hal/storage.hpp"

namespace tetragauge {

template <class Bus>
class FlashStorage final : public Storage {
 public:
  static constexpr uint32_t kFirstSector = 10;
  static constexpr uint32_t kFirstAddress = 0x080C'0000;  // table 5
  static constexpr uint32_t kSectorBytes = 128 * 1024;
  static constexpr uint32_t kBankWords = kSectorBytes / 4;
  // busy() is asked at least every millisecond of a running processor: 2 s and as much again.
  static constexpr uint32_t kBusyLooks = 4'000;
  // 100 us at most for a word (DS8626 table 39); 168 MHz, 5 cycles a look, and as much again.
  static constexpr uint32_t kWordTurns = 8'000;

  explicit FlashStorage(WaitFaults& faults) : faults_(faults) {}

  uint32_t bank_words() const override { return kBankWords; }

  bool erase(uint32_t bank) override {
    if (!ready()) return false;
    unlock();
    I::write(flash::kSectorErase(1) | flash::kSector(kFirstSector + bank) |
             flash::kParallelism(flash::kBy32));
    I::modify(flash::kStart(1));
    Bus::barrier();
    erasing_ = true;
    looks_ = 0;
    return true;
  }

  bool busy() const override {
    if (!erasing_) return false;
    if (!I::is(flash::kBusy(0))) {
      if (++looks_ < kBusyLooks) return true;
      faults_.add(WaitFault::kFlashBusy);
    }
    erasing_ = false;
    finish();
    return false;
  }

  bool write(uint32_t bank, uint32_t first_word, const uint32_t* words, uint32_t count) override {
    if (!ready()) return false;
    unlock();
    I::write(flash::kProgram(1) | flash::kParallelism(flash::kBy32));
    bool good = true;
    for (uint32_t i = 0; i < count && good; ++i) {
      Bus::write(address(bank, first_word + i), words[i]);
      Bus::barrier();
      good = faults_.wait_for<Bus>(flash::kBusy(0), kWordTurns, WaitFault::kFlashBusy);
    }
    finish();
    return ready() && good;
  }

  void read(uint32_t bank, uint32_t first_word, uint32_t* words, uint32_t count) const override {
    for (uint32_t i = 0; i < count; ++i) words[i] = Bus::read(address(bank, first_word + i));
  }

 private:
  using I = Io<Bus>;
  static constexpr uint32_t address(uint32_t bank, uint32_t word) {
    return kFirstAddress + bank * kSectorBytes + 4 * word;
  }
  bool ready() const { return good_ && !faults_.has(WaitFault::kFlashBusy); }
  void unlock() {
    good_ = true;
    I::write(flash::Sr{}, flash::kEndOfOperation.kMask | flash::kOperationError.kMask | flash::kErrors.kMask);
    I::write(flash::Keyr{}, flash::kKey1);
    I::write(flash::Keyr{}, flash::kKey2);
  }
  // Locked again; the data cache may hold what was there before (3.5.2 and 3.6.5: off, reset, on).
  void finish() const {
    good_ = I::is(flash::kErrors(0) | flash::kOperationError(0));
    I::write(flash::kLock(1));
    I::modify(flash::kDataCacheOn(0));
    I::modify(flash::kDataCacheReset(1));
    I::modify(flash::kDataCacheReset(0));
    I::modify(flash::kDataCacheOn(1));
  }

  WaitFaults& faults_;
  mutable bool erasing_ = false, good_ = true;
  mutable uint32_t looks_ = 0;
};

}  // namespace tetragauge
