// SPDX-License-Identifier: Apache-2.0
#include "firmware/storage/calibration_store.hpp"

#include "protocol/frame.hpp"

namespace tetragauge {

CalibrationStore::Copy CalibrationStore::copy_in(uint32_t bank) const {
  uint32_t head[kHeadWords];
  storage_.read(bank, 0, head, kHeadWords);
  Copy copy{false, head[1], head[2], head[3], bank};
  if (head[0] != kMagic || head[4] != crc32c(head, 16) || copy.bytes > kRecordBytes) return copy;
  uint32_t crc = 0;
  for (uint32_t at = 0; at < copy.bytes; at += 64) {
    uint32_t words[16];
    const uint32_t bytes = copy.bytes - at < 64 ? copy.bytes - at : 64;
    storage_.read(bank, kHeadWords + at / 4, words, words_of(bytes));
    crc = crc32c(words, bytes, crc);
  }
  copy.valid = crc == copy.crc;
  return copy;
}

void CalibrationStore::find() {
  newest_ = {};
  if (!present()) return;
  for (uint32_t bank = 0; bank < Storage::kBanks; ++bank) {
    const Copy copy = copy_in(bank);
    // The counter may turn over: newer is what lies less than half a turn ahead.
    const bool newer = static_cast<int32_t>(copy.counter - newest_.counter) > 0;
    if (copy.valid && (!newest_.valid || newer)) newest_ = copy;
  }
}

uint32_t CalibrationStore::valid_copies() const {
  uint32_t copies = 0;
  for (uint32_t bank = 0; bank < Storage::kBanks && newest_.valid; ++bank) {
    const Copy copy = copy_in(bank);
    copies += copy.valid && copy.counter == newest_.counter;
  }
  return copies;
}

void CalibrationStore::read(uint32_t offset, uint8_t* bytes, uint32_t count) const {
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t word = 0;
    storage_.read(newest_.bank, kHeadWords + (offset + i) / 4, &word, 1);
    bytes[i] = static_cast<uint8_t>(word >> (8 * ((offset + i) % 4)));
  }
}

const uint8_t* CalibrationStore::load() {
  staged_bytes_ = staged_total_ = 0;
  storage_.read(newest_.bank, kHeadWords, words_ + kHeadWords, words_of(total()));
  return written();
}

const char* CalibrationStore::write(const tg_CalibrationChunk& chunk) {
  if (chunk.total == 0 || chunk.total > kRecordBytes) return "total is 0 or longer than a record can be";
  if (chunk.offset == 0) {
    staged_bytes_ = 0;
    staged_total_ = chunk.total;
    staged_crc_ = chunk.crc;
  }
  if (chunk.total != staged_total_ || chunk.crc != staged_crc_ || chunk.offset != staged_bytes_) {
    return "chunks must come in order, from offset 0, with the same total and crc";
  }
  if (chunk.data.size == 0 || chunk.data.size > chunk.total - chunk.offset) {
    return "the chunk is empty or reaches beyond total";
  }
  auto* to = reinterpret_cast<uint8_t*>(words_ + kHeadWords) + chunk.offset;
  for (uint32_t i = 0; i < chunk.data.size; ++i) to[i] = chunk.data.bytes[i];
  staged_bytes_ += chunk.data.size;
  return nullptr;
}

const char* CalibrationStore::commit_error(const tg_CalibrationCommit& commit) const {
  if (!present()) return "this board has no store";
  if (commit.total == 0) return nullptr;
  if (staged_bytes_ != commit.total || staged_total_ != commit.total)
    return "the record is not written whole";
  if (commit.crc != staged_crc_ || crc32c(written(), commit.total) != commit.crc) {
    return "the CRC is another; write the record again";
  }
  return nullptr;
}

void CalibrationStore::commit(const tg_CalibrationCommit& commit) {
  auto* record = reinterpret_cast<uint8_t*>(words_ + kHeadWords);
  for (uint32_t i = commit.total; i < 4 * words_of(commit.total); ++i) record[i] = 0;
  words_[0] = kMagic;
  words_[1] = newest_.counter + 1;
  words_[2] = commit.total;
  words_[3] = crc32c(record, commit.total);
  words_[4] = crc32c(words_, 16);
  staged_bytes_ = staged_total_ = 0;
  bank_ = newest_.valid ? 1 - newest_.bank : 0;
  banks_done_ = 0;
  outcome_ = Outcome::kNone;
  job_ = Job::kErase;
}

// A store that is busy for long is left alone: the next call comes with the next poll().
void CalibrationStore::step() {
  if (job_ == Job::kNone || storage_.busy()) return;
  const uint32_t end = kHeadWords + words_of(words_[2]);
  bool good = true;
  switch (job_) {
    case Job::kErase:
      good = storage_.erase(bank_);
      at_word_ = kHeadWords;
      job_ = at_word_ < end ? Job::kWriteRecord : Job::kWriteHead;
      break;
    case Job::kWriteRecord: {
      const uint32_t count = end - at_word_ < kWordsAStep ? end - at_word_ : kWordsAStep;
      good = storage_.write(bank_, at_word_, words_ + at_word_, count);
      at_word_ += count;
      if (at_word_ == end) job_ = Job::kWriteHead;
      break;
    }
    case Job::kWriteHead:
      // Last: without it the record is not valid.
      good = storage_.write(bank_, 0, words_, kHeadWords);
      job_ = Job::kVerify;
      break;
    case Job::kVerify: {
      const Copy copy = copy_in(bank_);
      good = copy.valid && copy.counter == words_[1] && copy.crc == words_[3];
      if (!good) break;
      if (banks_done_ == 0) newest_ = copy;
      bank_ = 1 - bank_;
      job_ = ++banks_done_ < Storage::kBanks ? Job::kErase : Job::kNone;
      if (job_ == Job::kNone) outcome_ = Outcome::kStored;
      break;
    }
    case Job::kNone:
      break;
  }
  if (!good) bank_failed();
}

void CalibrationStore::bank_failed() {
  job_ = Job::kNone;
  outcome_ = banks_done_ == 0 ? Outcome::kFailed : Outcome::kOneCopy;
}

}  // namespace tetragauge
