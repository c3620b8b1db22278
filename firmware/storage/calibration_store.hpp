// SPDX-License-Identifier: Apache-2.0
// The calibration record in the board's store: two copies, the newest valid one counts.
//
//   CalibrationStore store(board.storage());
//   store.find();                                        // at start-up
//   if (store.total() > 0) use(store.load(), store.total());
//
// A new record comes in chunks (write), is taken into the store by commit() and step() until busy() is false,
// and is then in both banks. The bank with the newest record is written last, and only when the other holds
// the new one whole: a cut of power at any instant leaves the old record or the new one. An empty record
// (total 0) is a record too: it says that there is no calibration.
//
// A bank, in words: magic | counter | bytes of the record | CRC-32C of the record | CRC-32C of the four words
// before | the record, little-endian, its last word filled up with zeros.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/hal/storage.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

class CalibrationStore {
 public:
  static constexpr uint32_t kHeadWords = 5;
  static constexpr uint32_t kRecordBytes = tg_Calibration_size;
  static constexpr uint32_t kMagic = 0x54'47'43'31;  // "TGC1": a newer layout has another
  static constexpr uint32_t kWordsAStep = 32;

  explicit CalibrationStore(Storage& storage) : storage_(storage) {}

  void find();
  // What is in force: bytes of the record (0: none), their CRC-32C, how many banks hold it. Not while busy.
  uint32_t total() const { return newest_.valid ? newest_.bytes : 0; }
  uint32_t crc() const { return newest_.valid ? newest_.crc : 0; }
  uint32_t valid_copies() const;
  bool present() const { return storage_.bank_words() >= sizeof words_ / sizeof words_[0]; }
  bool ever_written() const { return newest_.valid; }
  // Of the record in force; the caller stays within total().
  void read(uint32_t offset, uint8_t* bytes, uint32_t count) const;
  // The whole record in force, in place of what was written of a new one.
  const uint8_t* load();

  // Null when the chunk was taken, else what is wrong with it. Offset 0 begins a new record.
  const char* write(const tg_CalibrationChunk& chunk);
  // The record written so far, whole or not.
  const uint8_t* written() const { return reinterpret_cast<const uint8_t*>(words_ + kHeadWords); }
  // Null when it is this one, whole; total 0 needs none.
  const char* commit_error(const tg_CalibrationCommit& commit) const;

  enum class Outcome : uint8_t {
    kNone,
    kStored,
    kOneCopy,  // in force, but the other bank does not take it
    kFailed,   // the old record is still in force
  };
  // The commit has no error. step() does a little at a time until busy() is false; then outcome() tells.
  void commit(const tg_CalibrationCommit& commit);
  bool busy() const { return job_ != Job::kNone; }
  void step();
  Outcome outcome() const { return outcome_; }

 private:
  enum class Job : uint8_t { kNone, kErase, kWriteRecord, kWriteHead, kVerify };
  struct Copy {
    bool valid = false;
    uint32_t counter = 0, bytes = 0, crc = 0, bank = 0;
  };
  Copy copy_in(uint32_t bank) const;
  void bank_failed();
  static uint32_t words_of(uint32_t bytes) { return (bytes + 3) / 4; }

  Storage& storage_;
  Copy newest_;

  uint32_t staged_bytes_ = 0, staged_total_ = 0, staged_crc_ = 0;
  Job job_ = Job::kNone;
  Outcome outcome_ = Outcome::kNone;
  uint32_t bank_ = 0, banks_done_ = 0, at_word_ = 0;
  uint32_t words_[kHeadWords + (kRecordBytes + 3) / 4] = {};  // as in a bank
};

}  // namespace tetragauge
