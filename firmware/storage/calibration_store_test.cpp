// SPDX-License-Identifier: Apache-2.0
#include "firmware/storage/calibration_store.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "firmware/hal/memory_storage.hpp"
#include "protocol/frame.hpp"

namespace tetragauge {
namespace {

using Bytes = std::vector<uint8_t>;

// Power goes when so many words have been changed: the word under way is left with any bits, as are, in an
// erasure, those not yet done. From then on nothing is changed any more.
class DyingStorage : public Storage {
 public:
  DyingStorage(const MemoryStorage& before, uint32_t words_until_cut, unsigned seed)
      : memory(before), left_(words_until_cut), random_(seed) {}
  uint32_t bank_words() const override { return memory.bank_words(); }
  bool erase(uint32_t bank) override {
    for (uint32_t i = 0; i < bank_words() && spend(memory.words[bank][i]); ++i)
      memory.words[bank][i] = kErasedWord;
    return true;
  }
  bool write(uint32_t bank, uint32_t first, const uint32_t* words, uint32_t count) override {
    for (uint32_t i = 0; i < count && spend(memory.words[bank][first + i]); ++i) {
      memory.words[bank][first + i] &= words[i];
    }
    return true;
  }
  bool busy() const override { return false; }
  void read(uint32_t bank, uint32_t first, uint32_t* words, uint32_t count) const override {
    memory.read(bank, first, words, count);
  }
  bool died() const { return died_; }

  MemoryStorage memory;

 private:
  bool spend(uint32_t& word) {
    if (died_) return false;
    if (left_-- > 0) return true;
    died_ = true;
    word = static_cast<uint32_t>(random_());
    return false;
  }
  uint32_t left_;
  bool died_ = false;
  std::mt19937 random_;
};

Bytes record_of(uint32_t size, unsigned seed) {
  std::mt19937 random(seed);
  Bytes record(size);
  for (uint8_t& byte : record) byte = static_cast<uint8_t>(random());
  return record;
}

bool write_all(CalibrationStore& store, const Bytes& record) {
  for (uint32_t at = 0; at < record.size(); at += 256) {
    tg_CalibrationChunk chunk = tg_CalibrationChunk_init_zero;
    chunk.offset = at;
    chunk.total = static_cast<uint32_t>(record.size());
    chunk.crc = crc32c(record.data(), record.size());
    chunk.data.size = static_cast<pb_size_t>(std::min<size_t>(256, record.size() - at));
    std::copy_n(record.begin() + at, chunk.data.size, chunk.data.bytes);
    if (store.write(chunk) != nullptr) return false;
  }
  return true;
}

CalibrationStore::Outcome store_it(CalibrationStore& store, const Bytes& record) {
  write_all(store, record);
  const tg_CalibrationCommit commit{static_cast<uint32_t>(record.size()),
                                    crc32c(record.data(), record.size())};
  EXPECT_EQ(store.commit_error(commit), nullptr);
  store.commit(commit);
  for (int step = 0; store.busy() && step < 1000; ++step) store.step();
  EXPECT_FALSE(store.busy());
  return store.outcome();
}

Bytes kept(Storage& storage) {
  CalibrationStore store(storage);
  store.find();
  Bytes record(store.total());
  store.read(0, record.data(), store.total());
  EXPECT_EQ(crc32c(record.data(), record.size()), store.total() > 0 ? store.crc() : 0u);
  return record;
}

TEST(CalibrationStore, KeepsTheNewestRecordInBothBanks) {
  MemoryStorage memory;
  CalibrationStore store(memory);
  store.find();
  EXPECT_EQ(store.total(), 0u);
  EXPECT_EQ(store.valid_copies(), 0u);
  for (unsigned k = 1; k <= 5; ++k) {
    const Bytes record = record_of(k * 263 % 1300 + 1, k);
    ASSERT_EQ(store_it(store, record), CalibrationStore::Outcome::kStored);
    EXPECT_EQ(store.valid_copies(), 2u);
    EXPECT_EQ(kept(memory), record);
  }
  ASSERT_EQ(store_it(store, {}), CalibrationStore::Outcome::kStored);
  EXPECT_EQ(kept(memory), Bytes{}) << "emptied: the older records do not come back";
}

TEST(CalibrationStore, EitherBankAloneIsEnough) {
  for (uint32_t bad_bank = 0; bad_bank < Storage::kBanks; ++bad_bank) {
    MemoryStorage memory;
    CalibrationStore store(memory);
    store.find();
    const Bytes record = record_of(900, 7);
    store_it(store, record);
    memory.words[bad_bank][100] ^= 1;
    EXPECT_EQ(kept(memory), record);
    CalibrationStore again(memory);
    again.find();
    EXPECT_EQ(again.valid_copies(), 1u);
  }
}

// At every word of every erasure and write, with several wrecks of the word under way: the old record or the
// new one.
TEST(CalibrationStore, APowerCutAtAnyWordLeavesTheOldRecordOrTheNewOne) {
  const Bytes old_record = record_of(700, 1), new_record = record_of(901, 2);
  for (const bool old_is_in_one_bank_only : {false, true}) {
    MemoryStorage before;
    CalibrationStore first(before);
    first.find();
    store_it(first, old_record);
    if (old_is_in_one_bank_only) before.words[0][20] ^= 1;
    bool completed = false;
    uint32_t cuts = 0, olds = 0, news = 0;
    for (uint32_t cut = 0; !completed; ++cut) {
      for (unsigned seed = 0; seed < 3; ++seed) {
        DyingStorage dying(before, cut, 1000 * cut + seed);
        CalibrationStore store(dying);
        store.find();
        ASSERT_EQ(store.total(), old_record.size());
        store_it(store, new_record);
        completed = !dying.died();
        const Bytes found = kept(dying.memory);
        ASSERT_TRUE(found == old_record || found == new_record) << "cut at word " << cut;
        ++(found == old_record ? olds : news);
        ++cuts;
      }
    }
    EXPECT_GT(olds, 1000u);
    EXPECT_GT(news, 1000u);
    std::printf("%u cuts: %u left the old record, %u the new one\n", cuts, olds, news);
  }
}

TEST(CalibrationStore, ABankThatDoesNotTakeItIsSaid) {
  const Bytes old_record = record_of(500, 3), new_record = record_of(500, 4);
  MemoryStorage before;
  CalibrationStore first(before);
  first.find();
  store_it(first, old_record);
  // Nothing takes at all: the old record stays in force.
  DyingStorage dead(before, 0, 1);
  CalibrationStore store(dead);
  store.find();
  EXPECT_EQ(store_it(store, new_record), CalibrationStore::Outcome::kFailed);
  EXPECT_EQ(store.total(), old_record.size());
  EXPECT_EQ(store.crc(), crc32c(old_record.data(), old_record.size()));
  // The first bank takes it, the second does not.
  DyingStorage tired(before, MemoryStorage::kBankWords + CalibrationStore::kHeadWords + 125 + 10, 1);
  CalibrationStore second(tired);
  second.find();
  EXPECT_EQ(store_it(second, new_record), CalibrationStore::Outcome::kOneCopy);
  EXPECT_EQ(kept(tired.memory), new_record);
}

TEST(CalibrationStore, TheCounterMayTurnOver) {
  MemoryStorage memory;
  const auto put = [&](uint32_t bank, uint32_t counter, uint8_t content) {
    uint32_t words[CalibrationStore::kHeadWords + 1] = {CalibrationStore::kMagic, counter, 1,
                                                        crc32c(&content, 1),      0,       content};
    words[4] = crc32c(words, 16);
    memory.erase(bank);
    memory.write(bank, 0, words, CalibrationStore::kHeadWords + 1);
  };
  put(0, 0xFFFFFFFF, 11);
  put(1, 0, 22);
  EXPECT_EQ(kept(memory), Bytes{22});
  put(1, 0xFFFFFFFE, 22);
  EXPECT_EQ(kept(memory), Bytes{11});
}

TEST(CalibrationStore, RefusesChunksThatDoNotFollow) {
  MemoryStorage memory;
  CalibrationStore store(memory);
  store.find();
  tg_CalibrationChunk chunk = tg_CalibrationChunk_init_zero;
  chunk.total = 100;
  chunk.data.size = 60;
  EXPECT_EQ(store.write(chunk), nullptr);
  tg_CalibrationChunk gap = chunk;
  gap.offset = 61;
  EXPECT_NE(store.write(gap), nullptr);
  tg_CalibrationChunk beyond = chunk;
  beyond.offset = 60;
  EXPECT_NE(store.write(beyond), nullptr) << "60 + 60 is beyond 100";
  tg_CalibrationChunk other = chunk;
  other.offset = 60;
  other.data.size = 40;
  other.crc = 1;
  EXPECT_NE(store.write(other), nullptr) << "of another record";
  other.crc = 0;
  EXPECT_EQ(store.write(other), nullptr);
  EXPECT_NE(store.commit_error({100, 5}), nullptr) << "wrong CRC";
  EXPECT_NE(store.commit_error({99, 0}), nullptr) << "not whole";
  tg_CalibrationChunk huge = chunk;
  huge.total = CalibrationStore::kRecordBytes + 1;
  EXPECT_NE(store.write(huge), nullptr);
}

}  // namespace
}  // namespace tetragauge
