// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/journal_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "host/base/whole_file.hpp"
#include "protocol/frame.hpp"

namespace tetragauge {
namespace {

static_assert(std::endian::native == std::endian::little, "records are written as they lie in memory");

constexpr std::string_view kMagic = "TGJRNL1\n";
constexpr size_t kHeadBytes = 5, kCrcBytes = 4;
constexpr std::chrono::seconds kSyncEvery{1};

uint32_t number_at(std::string_view bytes, size_t at) {
  uint32_t number = 0;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

void put_number(std::string& bytes, uint32_t number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

// The records up to the first that is not whole; `good_bytes` is where they end.
std::vector<JournalRecord> whole_records(std::string_view content, uint64_t& good_bytes) {
  std::vector<JournalRecord> records;
  size_t at = kMagic.size();
  while (content.size() - at >= kHeadBytes + kCrcBytes) {
    const size_t length = number_at(content, at);
    if (length > content.size() - at - kHeadBytes - kCrcBytes) break;
    const size_t end = at + kHeadBytes + length;
    if (crc32c(content.data() + at, kHeadBytes + length) != number_at(content, end)) break;
    records.push_back({content[at + 4], std::string(content.substr(at + kHeadBytes, length))});
    at = end + kCrcBytes;
  }
  good_bytes = at;
  return records;
}

// 0, or errno.
int write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(fd, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return errno;
    bytes.remove_prefix(static_cast<size_t>(put));
  }
  return 0;
}

}  // namespace

JournalFile::JournalFile(std::filesystem::path path, int fd, uint64_t bytes)
    : path_(std::move(path)), fd_(fd), bytes_(bytes), syncing_([this] { sync_until_closed(); }) {}

JournalFile::~JournalFile() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  wake_.notify_one();
  syncing_.join();
  ::close(fd_);
}

Error JournalFile::disk_error(int code) const {
  return bad_input("cannot write " + path_.string() + ": " + std::strerror(code) +
                   (code == ENOSPC || code == EDQUOT ? "; make room there" : "; see to that disk"));
}

Result<std::unique_ptr<JournalFile>> JournalFile::create(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
  if (fd < 0) return bad_input("cannot write " + path.string() + ": " + std::strerror(errno));
  std::unique_ptr<JournalFile> journal(new JournalFile(path, fd, kMagic.size()));
  ::flock(fd, LOCK_EX | LOCK_NB);
  if (const int failure = write_all(fd, kMagic); failure != 0) {
    ::unlink(path.c_str());
    return journal->disk_error(failure);
  }
  // The name too has to survive a power cut.
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (const int folder_fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); folder_fd >= 0) {
    ::fsync(folder_fd);
    ::close(folder_fd);
  }
  return journal;
}

Result<JournalFile::Opened> JournalFile::open(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (fd < 0) return bad_input("cannot write " + path.string() + ": " + std::strerror(errno));
  const auto fail = [fd](Error error) {
    ::close(fd);
    return error;
  };
  // Before it is read: whoever still appends to it must have ended.
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return fail(
        bad_input(path.string() + ": another tetragauge is measuring into it; let that one end first"));
  }
  const auto content = read_whole_file(path);
  if (!content) return fail(content.error());
  // One that was only just made when its program was killed holds less than its first bytes.
  const bool just_made = content->size() < kMagic.size() && kMagic.starts_with(*content);
  if (!just_made && !content->starts_with(kMagic)) {
    return fail(bad_input(path.string() + ": not the journal of a scan; move it out of the way"));
  }
  Opened opened;
  uint64_t good_bytes = 0;
  if (!just_made) opened.records = whole_records(*content, good_bytes);
  opened.bytes_cut = content->size() - good_bytes;
  if (opened.bytes_cut > 0 && ::ftruncate(fd, static_cast<off_t>(good_bytes)) != 0)
    return fail(bad_input("cannot write " + path.string() + ": " + std::strerror(errno)));
  if (just_made) {
    if (const int failure = write_all(fd, kMagic); failure != 0)
      return fail(bad_input("cannot write " + path.string() + ": " + std::strerror(failure)));
    good_bytes = kMagic.size();
  }
  opened.file.reset(new JournalFile(path, fd, good_bytes));
  return opened;
}

Status JournalFile::append(char kind, std::string_view payload) {
  std::string record;
  record.reserve(kHeadBytes + payload.size() + kCrcBytes);
  put_number(record, static_cast<uint32_t>(payload.size()));
  record += kind;
  record += payload;
  put_number(record, crc32c(record.data(), record.size()));
  {
    const std::lock_guard lock(mutex_);
    if (sync_failure_ != 0) return disk_error(sync_failure_);
  }
  if (const int failure = write_all(fd_, record); failure != 0) {
    // Half a record would be cut off at the next opening; without it there is nothing to cut.
    (void)!::ftruncate(fd_, static_cast<off_t>(bytes_));
    return disk_error(failure);
  }
  bytes_ += record.size();
  const std::lock_guard lock(mutex_);
  dirty_ = true;
  return Done{};
}

void JournalFile::sync_soon() {
  {
    const std::lock_guard lock(mutex_);
    soon_ = true;
  }
  wake_.notify_one();
}

// In a thread of its own: a disk that takes long must not make the host silent.
void JournalFile::sync_until_closed() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait_for(lock, kSyncEvery, [this] { return soon_ || closing_; });
    const bool last = closing_;
    soon_ = false;
    if (std::exchange(dirty_, false)) {
      lock.unlock();
      const int failure = ::fdatasync(fd_) == 0 || errno == EINVAL ? 0 : errno;
      lock.lock();
      if (failure != 0) sync_failure_ = failure;
    }
    if (last) return;
  }
}

}  // namespace tetragauge
