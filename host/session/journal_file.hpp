// SPDX-License-Identifier: GPL-3.0-or-later
// A file that only grows, record by record, each with its CRC: whatever was appended is there when this
// program is killed, and what is there after a power cut is whole up to some record.
//
//   auto journal = JournalFile::create("scan.ply.journal");
//   (*journal)->append('s', bytes);          // in the file when it returns; on the disk within a second
//
// Format: 8 bytes "TGJRNL1\n", then records: u32 length, u8 kind, payload, u32 CRC-32C over the three;
// little-endian.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "host/base/result.hpp"

namespace tetragauge {

struct JournalRecord {
  char kind = 0;
  std::string payload;
};

class JournalFile {
 public:
  // Errors: it exists, or cannot be made.
  static Result<std::unique_ptr<JournalFile>> create(const std::filesystem::path& path);

  struct Opened;
  // Reads what is there, cuts off what is damaged or half written at its end, and goes on from there. Errors:
  // no such file, no journal, in use by another program.
  static Result<Opened> open(const std::filesystem::path& path);

  ~JournalFile();  // what was appended is on the disk
  JournalFile(const JournalFile&) = delete;
  JournalFile& operator=(const JournalFile&) = delete;

  // All or nothing. A full or failing disk is an error, then or at the next call.
  Status append(char kind, std::string_view payload);
  // To the disk now rather than within the second; does not wait for it.
  void sync_soon();

  const std::filesystem::path& path() const { return path_; }

 private:
  JournalFile(std::filesystem::path path, int fd, uint64_t bytes);
  Error disk_error(int code) const;
  void sync_until_closed();

  std::filesystem::path path_;
  int fd_;
  uint64_t bytes_;    // whole records
  std::mutex mutex_;  // of the members below
  std::condition_variable wake_;
  bool dirty_ = false, soon_ = false, closing_ = false;
  int sync_failure_ = 0;  // errno
  std::thread syncing_;   // the last member: it uses the others
};

struct JournalFile::Opened {
  std::unique_ptr<JournalFile> file;
  std::vector<JournalRecord> records;
  uint64_t bytes_cut = 0;
};

}  // namespace tetragauge
