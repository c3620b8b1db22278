// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/journal_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "host/base/whole_file.hpp"
#include "host/session/emulated_session.hpp"

namespace tetragauge {
namespace {

std::filesystem::path fresh(const std::string& name) {
  const auto path = temporary_folder() / name;
  std::filesystem::remove(path);
  return path;
}

std::string content_of(const std::filesystem::path& path) {
  return *read_whole_file(path);
}

void put(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

std::vector<std::string> payloads(const std::filesystem::path& path) {
  const auto opened = JournalFile::open(path);
  EXPECT_TRUE(opened) << opened.error().message;
  std::vector<std::string> list;
  if (opened)
    for (const JournalRecord& record : opened->records) list.push_back(record.payload);
  return list;
}

const std::vector<std::string> kPayloads{"order", "", std::string(300, '\0'), "fourth"};

std::filesystem::path journal_of_four(const std::string& name) {
  const auto path = fresh(name);
  auto journal = JournalFile::create(path);
  EXPECT_TRUE(journal) << journal.error().message;
  for (const std::string& payload : kPayloads) EXPECT_TRUE((*journal)->append('x', payload));
  return path;
}

TEST(JournalFile, GivesBackWhatWasAppendedAndGoesOn) {
  const auto path = journal_of_four("four");
  {
    auto opened = JournalFile::open(path);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->bytes_cut, 0u);
    ASSERT_EQ(opened->records.size(), 4u);
    EXPECT_EQ(opened->records[3].kind, 'x');
    ASSERT_TRUE(opened->file->append('y', "fifth"));
  }
  const auto all = payloads(path);
  ASSERT_EQ(all.size(), 5u);
  EXPECT_EQ(all[2], kPayloads[2]);
  EXPECT_EQ(all[4], "fifth");
}

TEST(JournalFile, IsNeverOverwritten) {
  const auto path = journal_of_four("kept");
  const std::string before = content_of(path);
  EXPECT_FALSE(JournalFile::create(path));
  EXPECT_EQ(content_of(path), before);
}

TEST(JournalFile, EveryTruncationLeavesTheWholeRecordsBeforeIt) {
  const std::string whole = content_of(journal_of_four("cut"));
  const auto path = fresh("cut_short");
  size_t most = 0;
  for (size_t size = 0; size <= whole.size(); ++size) {
    put(path, whole.substr(0, size));
    const auto left = payloads(path);
    EXPECT_GE(left.size(), most) << size;
    most = left.size();
    for (size_t i = 0; i < left.size(); ++i) EXPECT_EQ(left[i], kPayloads[i]);
    // What was cut is gone for good: the next opening finds the same, and nothing to cut.
    const auto again = JournalFile::open(path);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->bytes_cut, 0u);
    EXPECT_EQ(again->records.size(), left.size());
  }
  EXPECT_EQ(most, kPayloads.size());
}

TEST(JournalFile, EveryDamagedByteEndsItThere) {
  const std::string whole = content_of(journal_of_four("damaged"));
  const auto path = fresh("flipped");
  for (size_t at = 8; at < whole.size(); ++at) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    put(path, flipped);
    const auto left = payloads(path);
    EXPECT_LT(left.size(), kPayloads.size()) << "byte " << at;
    for (size_t i = 0; i < left.size(); ++i) EXPECT_EQ(left[i], kPayloads[i]);
  }
}

TEST(JournalFile, OtherFilesAndOtherUsersAreRefused) {
  const auto other = fresh("other");
  put(other, "my diary\n");
  const auto opened = JournalFile::open(other);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("not the journal"), std::string::npos) << opened.error().message;
  EXPECT_EQ(content_of(other), "my diary\n");
  EXPECT_FALSE(JournalFile::open(fresh("missing")));

  const auto path = journal_of_four("busy");
  const auto first = JournalFile::open(path);
  ASSERT_TRUE(first);
  const auto second = JournalFile::open(path);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("another tetragauge"), std::string::npos) << second.error().message;
}

// The limit on a file's size stands for a full disk: write() fails in the middle of a record.
TEST(JournalFile, FullDiskIsAnErrorAndLeavesWholeRecords) {
  const auto path = fresh("full");
  auto journal = JournalFile::create(path);
  ASSERT_TRUE(journal);
  ASSERT_TRUE((*journal)->append('x', "first"));
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{100, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &small);
  const Status kept = (*journal)->append('x', std::string(200, 'z'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(kept);
  EXPECT_NE(kept.error().message.find("full"), std::string::npos) << kept.error().message;
  journal->reset();
  const auto opened = JournalFile::open(path);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->records.size(), 1u);
  EXPECT_EQ(opened->bytes_cut, 0u);
}

}  // namespace
}  // namespace tetragauge
