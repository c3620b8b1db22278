// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/file_storage.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace tetragauge {
namespace {

class FileStorageTest : public testing::Test {
 protected:
  void SetUp() override {
    path = std::filesystem::path(testing::TempDir()) /
           (std::string("store_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove(path);
  }
  void TearDown() override { std::filesystem::remove(path); }
  std::filesystem::path path;
};

TEST_F(FileStorageTest, KeepsItsWordsWhenOpenedAgain) {
  {
    const auto store = FileStorage::open(path);
    ASSERT_TRUE(store) << store.error().message;
    uint32_t word = 0;
    (*store)->read(1, 7, &word, 1);
    EXPECT_EQ(word, Storage::kErasedWord);
    const uint32_t words[] = {1, 0xCAFEF00D};
    EXPECT_TRUE((*store)->write(1, 7, words, 2));
  }
  const auto store = FileStorage::open(path);
  ASSERT_TRUE(store) << store.error().message;
  uint32_t words[4];
  (*store)->read(1, 6, words, 4);
  EXPECT_EQ(words[0], Storage::kErasedWord);
  EXPECT_EQ(words[1], 1u);
  EXPECT_EQ(words[2], 0xCAFEF00Du);
  EXPECT_EQ(words[3], Storage::kErasedWord);
  // As flash: what was not erased only loses bits.
  const uint32_t other = 0x0000FFFF;
  EXPECT_TRUE((*store)->write(1, 8, &other, 1));
  (*store)->read(1, 8, words, 1);
  EXPECT_EQ(words[0], 0x0000F00Du);
  EXPECT_TRUE((*store)->erase(1));
  (*store)->read(1, 8, words, 1);
  EXPECT_EQ(words[0], Storage::kErasedWord);
}

TEST_F(FileStorageTest, RefusesAFileThatIsNoStore) {
  std::ofstream(path) << "something else";
  const auto store = FileStorage::open(path);
  ASSERT_FALSE(store);
  EXPECT_NE(store.error().message.find("is no machine's store"), std::string::npos) << store.error().message;
  EXPECT_EQ(std::filesystem::file_size(path), 14u) << "and leaves it as it is";
}

TEST_F(FileStorageTest, SaysWhichFileItCannotOpen) {
  const auto store = FileStorage::open("/no/such/folder/store");
  ASSERT_FALSE(store);
  EXPECT_NE(store.error().message.find("/no/such/folder/store"), std::string::npos);
}

}  // namespace
}  // namespace tetragauge
