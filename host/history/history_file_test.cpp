// SPDX-License-Identifier: GPL-3.0-or-later
// The file as other programs, accidents and time leave it. SQLite is used directly here to make them.
#include "host/history/history_file.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "host/base/whole_file.hpp"

namespace tetragauge {
namespace {

namespace fs = std::filesystem;

class HistoryTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("tetragauge-history-" + std::string(test->name()) + "-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path file(const std::string& name = "history.db") const { return folder_ / name; }
  void write(const fs::path& path, const std::string& content) const { std::ofstream(path) << content; }
  void execute(const fs::path& path, const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
    sqlite3_close(database);
  }

  fs::path folder_;
};

PartRecord bracket(const std::string& serial, size_t faces = 3) {
  PartRecord record;
  record.part = serial;
  record.model_sha256 = "ab12";
  record.model_name = "bracket.step";
  record.held_by = "best fit";
  record.machine_id = "emulated";
  record.seed = 18446744073709551615u;
  record.software = "tetragauge test";
  record.verdict = Verdict::fail;
  for (size_t k = 1; k <= faces; ++k) {
    FaceRecord face{.face = static_cast<int>(k), .type = "plane", .reason = "", .quantities = {}};
    face.measured = k != 2;
    face.coverage = 0.1 * static_cast<double>(k);
    face.verdict = k == 1 ? Verdict::fail : Verdict::not_measured;
    if (face.measured) {
      face.quantities.push_back(
          {.name = "offset", .unit = "mm", .value = 0.1 + 0.2, .U = 1e-3, .lower = -0.1, .upper = 0.1});
      face.quantities.push_back({.name = "form", .unit = "mm", .value = 1.0 / 3, .U = 0, .is_known = false});
    }
    record.faces.push_back(face);
  }
  return record;
}

std::vector<PartRecord> read(const fs::path& path) {
  auto opened = HistoryFile::open_to_read(path);
  EXPECT_TRUE(opened) << opened.error().message;
  if (!opened) return {};
  auto parts = opened->parts();
  EXPECT_TRUE(parts) << parts.error().message;
  return parts ? *parts : std::vector<PartRecord>{};
}

void expect_error(const Error& error, const std::string& words) {
  EXPECT_EQ(error.kind, ErrorKind::bad_input);
  EXPECT_NE(error.message.find(words), std::string::npos) << error.message;
  EXPECT_NE(error.message.find("history.db"), std::string::npos) << error.message;
}

TEST_F(HistoryTest, WhatIsAddedIsReadToTheLastBit) {
  auto opened = HistoryFile::open_to_add(file());
  ASSERT_TRUE(opened) << opened.error().message;
  PartRecord nasty = bracket("'); DROP TABLE part; --\n\xC3\xA9 \"");
  nasty.reason = "";
  ASSERT_EQ(opened->add(nasty).value(), 1);
  PartRecord unmeasured = bracket("B", 0);
  unmeasured.verdict = Verdict::not_measured;
  unmeasured.reason = "interlock opened";
  unmeasured.seed.reset();
  ASSERT_EQ(opened->add(unmeasured).value(), 2);

  const std::vector<PartRecord> parts = read(file());
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].number, 1);
  EXPECT_EQ(parts[0].part, nasty.part);
  EXPECT_EQ(parts[0].seed, nasty.seed);
  EXPECT_EQ(parts[0].verdict, Verdict::fail);
  ASSERT_EQ(parts[0].faces.size(), 3u);
  EXPECT_FALSE(parts[0].faces[1].measured);
  EXPECT_TRUE(parts[0].faces[1].quantities.empty());
  const Quantity& offset = parts[0].faces[2].quantities.at(0);
  EXPECT_EQ(offset.value, 0.1 + 0.2);
  EXPECT_EQ(offset.lower, -0.1);
  EXPECT_TRUE(offset.is_known);
  const Quantity& form = parts[0].faces[2].quantities.at(1);
  EXPECT_EQ(form.name, "form");
  EXPECT_EQ(form.value, 1.0 / 3);
  EXPECT_FALSE(form.lower || form.upper || form.is_known);
  EXPECT_EQ(parts[1].reason, "interlock opened");
  EXPECT_FALSE(parts[1].seed);
  EXPECT_TRUE(parts[1].faces.empty());
}

TEST_F(HistoryTest, ASecondRunGoesOnAndEqualRunsMakeEqualFiles) {
  for (const char* name : {"history.db", "again.db"}) {
    for (int run = 0; run < 2; ++run) {
      auto opened = HistoryFile::open_to_add(file(name));
      ASSERT_TRUE(opened) << opened.error().message;
      EXPECT_EQ(opened->add(bracket("A")).value(), 2 * run + 1);
      EXPECT_EQ(opened->add(bracket("B")).value(), 2 * run + 2);
    }
  }
  EXPECT_EQ(read(file()).size(), 4u);
  EXPECT_TRUE(*read_whole_file(file()) == *read_whole_file(file("again.db")));
  EXPECT_FALSE(fs::exists(file("history.db-journal")));
}

TEST_F(HistoryTest, WhatIsNoHistory) {
  write(file(), "solid staircase\n facet normal 0 0 1\n outer loop\n" + std::string(2000, 'x'));
  const std::string before = *read_whole_file(file());
  expect_error(HistoryFile::open_to_read(file()).error(), "not an SQLite database");
  expect_error(HistoryFile::open_to_add(file()).error(), "not an SQLite database");
  EXPECT_EQ(*read_whole_file(file()), before);
  expect_error(HistoryFile::open_to_read(file("no.history.db")).error(), "no such file");
  EXPECT_FALSE(fs::exists(file("no.history.db")));
  fs::create_directories(file("folder.history.db"));
  expect_error(HistoryFile::open_to_add(file("folder.history.db")).error(), "no regular file");
  expect_error(HistoryFile::open_to_add(file("absent/history.db")).error(), "must be writable");
}

TEST_F(HistoryTest, AnotherProgramsDatabaseIsLeftAlone) {
  execute(file(), "CREATE TABLE bookmarks (url TEXT)");
  const std::string before = *read_whole_file(file());
  expect_error(HistoryFile::open_to_read(file()).error(), "another program");
  expect_error(HistoryFile::open_to_add(file()).error(), "another program");
  EXPECT_TRUE(*read_whole_file(file()) == before);
}

TEST_F(HistoryTest, AnEmptyFileIsNoHistoryYet) {
  write(file(), "");
  expect_error(HistoryFile::open_to_read(file()).error(), "nothing in it");
  ASSERT_TRUE(HistoryFile::open_to_add(file()));
  EXPECT_TRUE(read(file()).empty());
}

TEST_F(HistoryTest, ANewerVersionSaysSo) {
  ASSERT_TRUE(HistoryFile::open_to_add(file()));
  execute(file(), "PRAGMA user_version = 2");
  expect_error(HistoryFile::open_to_read(file()).error(), "newer tetragauge");
  expect_error(HistoryFile::open_to_add(file()).error(), "newer tetragauge");
}

TEST_F(HistoryTest, ADamagedFileSaysSo) {
  {
    auto opened = HistoryFile::open_to_add(file());
    for (int k = 0; k < 50; ++k) ASSERT_TRUE(opened->add(bracket("A", 20)));
  }
  fs::resize_file(file(), fs::file_size(file()) / 2);
  auto opened = HistoryFile::open_to_read(file());
  expect_error(opened ? opened->parts().error() : opened.error(), "damaged");
}

TEST_F(HistoryTest, AReadOnlyPlaceIsReadAndNotWritten) {
  { ASSERT_TRUE(HistoryFile::open_to_add(file())->add(bracket("A"))); }
  fs::permissions(file(), fs::perms{0444});
  fs::permissions(folder_, fs::perms{0555});
  const pid_t pid = ::fork();
  if (pid == 0) {
    // The superuser may write everywhere: somebody else tries.
    constexpr uid_t kNobody = 65534;
    if (::geteuid() == 0 && ::setuid(kNobody) != 0) ::_exit(1);
    const auto added = HistoryFile::open_to_add(file());
    const bool said = !added && added.error().kind == ErrorKind::bad_input &&
                      added.error().message.find("must be writable") != std::string::npos;
    auto opened = HistoryFile::open_to_read(file());
    const auto parts = opened ? opened->parts() : Result<std::vector<PartRecord>>(opened.error());
    ::_exit(!said ? 2 : !parts ? 3 : parts->size() != 1 ? 4 : 0);
  }
  int status = 0;
  ::waitpid(pid, &status, 0);
  EXPECT_EQ(status, 0);
  fs::permissions(folder_, fs::perms::owner_all);
}

TEST_F(HistoryTest, AWriterThatStaysIsWaitedForThenNamed) {
  { ASSERT_TRUE(HistoryFile::open_to_add(file())); }
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(file().c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN EXCLUSIVE", nullptr, nullptr, nullptr), SQLITE_OK);
  const HistoryOptions soon{.wait_for_others = std::chrono::milliseconds(50)};
  expect_error(HistoryFile::open_to_add(file(), soon).error(), "another program");
  expect_error(HistoryFile::open_to_read(file(), soon).error(), "another program");
  sqlite3_exec(other, "ROLLBACK", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  EXPECT_TRUE(HistoryFile::open_to_add(file(), soon));
}

// From no file at all: making the tables is raced for, too.
TEST_F(HistoryTest, TwoProgramsAddAtOnce) {
  std::vector<pid_t> children;
  for (int child = 0; child < 3; ++child) {
    const pid_t pid = ::fork();
    if (pid == 0) {
      auto opened = HistoryFile::open_to_add(file());
      bool good = opened.ok();
      for (int k = 0; good && k < 15; ++k) good = opened->add(bracket(std::to_string(child))).ok();
      ::_exit(good ? 0 : 1);
    }
    children.push_back(pid);
  }
  for (const pid_t pid : children) {
    int status = 0;
    ::waitpid(pid, &status, 0);
    EXPECT_EQ(status, 0);
  }
  const std::vector<PartRecord> parts = read(file());
  ASSERT_EQ(parts.size(), 45u);
  for (size_t k = 0; k < parts.size(); ++k) {
    EXPECT_EQ(parts[k].number, static_cast<int64_t>(k + 1));
    EXPECT_EQ(parts[k].faces.size(), 3u);
  }
}

TEST_F(HistoryTest, KilledAtAnyMomentLeavesWholeParts) {
  ASSERT_TRUE(HistoryFile::open_to_add(file()));
  size_t before = 0;
  for (int round = 0; round < 12; ++round) {
    const pid_t pid = ::fork();
    if (pid == 0) {
      auto opened = HistoryFile::open_to_add(file());
      while (opened && opened->add(bracket("A", 40))) continue;
      ::_exit(1);
    }
    ::usleep(static_cast<useconds_t>(15'000 + 3'517 * round));
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
    const std::vector<PartRecord> parts = read(file());
    EXPECT_GE(parts.size(), before) << "what was added stays";
    before = parts.size();
    for (const PartRecord& part : parts) {
      ASSERT_EQ(part.faces.size(), 40u);
      for (const FaceRecord& face : part.faces) EXPECT_EQ(face.quantities.size(), face.measured ? 2u : 0u);
    }
  }
  EXPECT_GT(before, 0u);
}

TEST_F(HistoryTest, KilledWhileMakingTheFileLeavesOneToGoOnWith) {
  for (int round = 0; round < 12; ++round) {
    fs::remove(file());
    const pid_t pid = ::fork();
    if (pid == 0) {
      (void)HistoryFile::open_to_add(file());
      ::pause();
    }
    ::usleep(static_cast<useconds_t>(300 + 700 * round));
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
    auto opened = HistoryFile::open_to_add(file());
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->add(bracket("A")).value(), 1);
  }
}

// A limit on the size of files stands for a disk that is full.
TEST_F(HistoryTest, AFullDiskKeepsThePartsBefore) {
  { ASSERT_TRUE(HistoryFile::open_to_add(file())->add(bracket("first"))); }
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{fs::file_size(file()) + 20'000, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    auto opened = HistoryFile::open_to_add(file());
    if (!opened) ::_exit(1);
    const auto added = opened->add(bracket("too much", 2000));
    const bool said = !added && added.error().kind == ErrorKind::bad_input &&
                      added.error().message.find("the parts before are kept") != std::string::npos;
    ::_exit(said ? 0 : 2);
  }
  int status = 0;
  ::waitpid(pid, &status, 0);
  EXPECT_EQ(status, 0);
  const std::vector<PartRecord> parts = read(file());
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].part, "first");
}

TEST_F(HistoryTest, NoNumberIsNotKept) {
  auto opened = HistoryFile::open_to_add(file());
  PartRecord record = bracket("A");
  record.faces[0].quantities[0].value = std::nan("");
  EXPECT_FALSE(opened->add(record));
  EXPECT_TRUE(read(file()).empty());
}

}  // namespace
}  // namespace tetragauge
