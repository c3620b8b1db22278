// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/whole_file.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

namespace tetragauge {
namespace {

namespace fs = std::filesystem;

class WholeFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tetragauge-base-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  size_t entries(const fs::path& folder) const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  void expect_refused(const fs::path& path, const std::string& word) const {
    const fs::file_type before = fs::symlink_status(path).type();
    const size_t entries_before = entries(folder_);
    const Status status = write_whole_file(path, "x");
    ASSERT_FALSE(status) << path;
    EXPECT_EQ(status.error().kind, ErrorKind::bad_input);
    EXPECT_NE(status.error().message.find(path.string()), std::string::npos) << status.error().message;
    EXPECT_NE(status.error().message.find(word), std::string::npos) << status.error().message;
    EXPECT_EQ(fs::symlink_status(path).type(), before);
    EXPECT_EQ(entries(folder_), entries_before);
  }
  std::string content(const fs::path& path) const {
    const Result<std::string> read = read_whole_file(path);
    return read ? *read : "unreadable";
  }

  fs::path folder_;
};

TEST_F(WholeFile, AppearsAndIsReplacedWhole) {
  const std::string large(300'000, 'a');
  ASSERT_TRUE(write_whole_file(folder_ / "file", large));
  EXPECT_TRUE(content(folder_ / "file") == large);
  ASSERT_TRUE(write_whole_file(folder_ / "file", "short"));
  EXPECT_EQ(content(folder_ / "file"), "short");
  EXPECT_EQ(entries(folder_), 1u);
}

TEST_F(WholeFile, ReplacesNothingButRegularFiles) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  expect_refused(folder_ / "pipe", "a pipe");

  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = (folder_ / "socket").string();
  ASSERT_LT(path.size(), sizeof address.sun_path);
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  expect_refused(path, "a socket");
  ::close(fd);

  fs::create_directory(folder_ / "folder");
  expect_refused(folder_ / "folder", "a folder");
  fs::create_symlink("pipe", folder_ / "link");
  expect_refused(folder_ / "link", "a pipe");
  fs::create_symlink("round", folder_ / "round");
  expect_refused(folder_ / "round", "links");
}

TEST_F(WholeFile, FollowsLinksToTheFileTheyMean) {
  fs::create_directory(folder_ / "far");
  ASSERT_TRUE(write_whole_file(folder_ / "far" / "file", "old"));
  fs::create_symlink("file", folder_ / "far" / "link");
  fs::create_symlink("far/link", folder_ / "link");
  fs::create_symlink(folder_ / "far" / "new", folder_ / "dangling");
  ASSERT_TRUE(write_whole_file(folder_ / "link", "new"));
  EXPECT_EQ(content(folder_ / "far" / "file"), "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "far" / "link"));
  ASSERT_TRUE(write_whole_file(folder_ / "dangling", "made"));
  EXPECT_EQ(content(folder_ / "far" / "new"), "made");
  EXPECT_TRUE(fs::is_symlink(folder_ / "dangling"));
  EXPECT_EQ(entries(folder_ / "far"), 3u);
}

}  // namespace
}  // namespace tetragauge
