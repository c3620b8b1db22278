// SPDX-License-Identifier: GPL-3.0-or-later
// The history of a production: one SQLite file, one row per part and per face of it.
//
//   auto file = HistoryFile::open_to_add("brackets.db");   // makes it when there is none
//   file->add(record);                                     // the whole part or nothing of it
//   auto parts = HistoryFile::open_to_read("brackets.db")->parts();
//
// Several programs may use one file at once; each waits for the others for some seconds. Every failure is
// ErrorKind::bad_input, names the file and says what to do next.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <vector>

#include "host/base/result.hpp"
#include "host/history/part_record.hpp"

struct sqlite3;

namespace tetragauge {

struct HistoryOptions {
  std::chrono::milliseconds wait_for_others{15'000};  // while another program writes
};

class HistoryFile {
 public:
  static Result<HistoryFile> open_to_read(const std::filesystem::path& path, HistoryOptions options = {});
  // Fails now, not after the first part was measured, when nothing can be written.
  static Result<HistoryFile> open_to_add(const std::filesystem::path& path, HistoryOptions options = {});

  // One transaction; on the disk when it returns. The part's running number.
  Result<int64_t> add(const PartRecord& record);
  // All of them in the order in which they were added.
  Result<std::vector<PartRecord>> parts();

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  using Database = std::unique_ptr<sqlite3, Close>;
  HistoryFile(Database database, std::string name) : database_(std::move(database)), name_(std::move(name)) {}
  static Result<HistoryFile> open(const std::filesystem::path& path, int flags, HistoryOptions options);
  Status check_schema(bool make);
  Status insert(PartRecord record, int64_t& number);

  Database database_;
  std::string name_;  // of the file, for messages
};

}  // namespace tetragauge
