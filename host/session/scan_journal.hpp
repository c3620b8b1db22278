// SPDX-License-Identifier: GPL-3.0-or-later
// What a scan session has to remember to be gone on with after it was killed: what was asked for, the
// machine, the plan, and every stream item, each before the machine may forget it. Messages are kept as the
// frames they were on the wire.
//
//   auto journal = ScanJournal::begin(journal_of("scan.ply"), order);
//   run_scan(link, plan, {.journal = journal->get()});
//   ... killed ...
//   auto journal = ScanJournal::reopen(journal_of("scan.ply"));
//   resume_scan(link, {.journal = journal->get()});
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "host/link/link.hpp"
#include "host/session/journal_file.hpp"
#include "host/session/load_plan.hpp"
#include "host/session/rest_of_plan.hpp"

namespace tetragauge {

// scan.ply.journal beside scan.ply
std::filesystem::path journal_of(const std::filesystem::path& scan);

// The machine a scan was begun with, and the whole plan as it was given to the machine.
struct JournaledPlan {
  tg_HelloReply machine = tg_HelloReply_init_zero;
  tg_GalvoConfig galvo = tg_GalvoConfig_init_zero;
  tg_StageConfig stage = tg_StageConfig_init_zero;
  std::vector<tg_View> views;
};

// One go at the plan or at the rest of it: from ScanStart until the session was killed, or to its end.
struct JournaledRun {
  uint32_t boot_id = 0;  // of the machine
  uint32_t plan_id = 0;  // of what was loaded: rest_of_plan(views, from)
  BeamPlace from;
  std::vector<std::string> items;  // stream items 0, 1, ... as frames, a tenth of the messages' size
};

tg_MachineMessage message_of_item(const std::string& frame);

class ScanJournal {
 public:
  // `order`: whatever the caller needs to go on, given back by order(). Errors: see JournalFile::create.
  static Result<std::unique_ptr<ScanJournal>> begin(const std::filesystem::path& path,
                                                    const nlohmann::ordered_json& order);
  static Result<std::unique_ptr<ScanJournal>> reopen(const std::filesystem::path& path);

  // Null: the session was killed while it made the journal.
  const nlohmann::ordered_json& order() const { return order_; }
  // Nothing: the session was killed before it had a plan.
  const std::optional<JournaledPlan>& plan() const { return plan_; }
  // With what was in them when the journal was reopened.
  const std::vector<JournaledRun>& runs() const { return runs_; }
  // Kept so far, in all sessions.
  size_t items() const { return items_; }
  // Of a damaged end, when it was reopened.
  uint64_t bytes_cut() const { return bytes_cut_; }
  const std::filesystem::path& path() const { return file_->path(); }

  Status keep_plan(JournaledPlan plan);
  Status keep_run(const JournaledRun& run);
  // The next item of the last run. At each view's end it goes to the disk at once.
  Status keep_item(const tg_MachineMessage& item);

  // The scan is written, or nothing worth keeping is in it.
  void remove();

 private:
  explicit ScanJournal(std::unique_ptr<JournalFile> file) : file_(std::move(file)) {}
  Status read(const JournalRecord& record);

  std::unique_ptr<JournalFile> file_;
  nlohmann::ordered_json order_;
  std::optional<JournaledPlan> plan_;
  std::vector<JournaledRun> runs_;
  uint64_t bytes_cut_ = 0;
  uint32_t last_view_ = 0;
  size_t items_ = 0;
};

}  // namespace tetragauge
