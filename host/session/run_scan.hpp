// SPDX-License-Identifier: GPL-3.0-or-later
// A whole scan session with a machine, real or emulated:
//
//   auto plan = default_plan(link);              // or read_plan(path)
//   auto measured = run_scan(link, *plan);
//   write_scan("scan.ply", measured->scan);
//
// Homes the machine if need be, loads the plan, measures, takes every beam in order (asking again for what
// got lost), and compares count and checksum with the machine's own. On any error, and when asked to stop,
// the machine is told to abort (laser off) and there is no scan; with a journal, resume_scan goes on from
// there.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "host/base/result.hpp"
#include "host/link/link.hpp"
#include "host/scan/scan.hpp"
#include "host/session/plan.hpp"

namespace tetragauge {

class ScanJournal;

struct ScanCounts {
  size_t beams = 0, points = 0;
  size_t table_points = 0;               // dropped: on the table's top
  size_t unsettled = 0, one_camera = 0;  // of the points kept
  std::array<size_t, 8> rejected{};      // by tg_RejectReason
  // From start to end by the machine's clock; after a resumed scan its last run, with that run's beams.
  double machine_time_s = 0;
  size_t timed_beams = 0;
};

struct ScanProgress {
  bool survey = false;         // of default_plan()
  size_t view = 0, views = 0;  // view: from 1
  size_t beams_planned = 0;
  size_t beams_resumed = 0;  // of counts.beams, those of earlier sessions
  ScanCounts counts;
};

struct ScanOptions {
  bool keep_table = false;                                 // keep points on the table's top
  std::optional<uint64_t> seed{};                          // of an emulated machine, for the scan's header
  std::string part_serial{}, operator_name{};              // for the scan's header
  std::string start_time{};                                // the same; of real hardware only
  const std::atomic<bool>* stop = nullptr;                 // set (Ctrl-C): abort
  std::function<void(const ScanProgress&)> on_progress{};  // after each batch
  std::function<void(const std::string&)> log{};           // what the session does, one line each
  std::function<void(const std::string&)> on_stage{};      // what the host begins between scans, in words
  // Keeps the plan and every stream item before the machine may forget it (scan_journal.hpp).
  ScanJournal* journal = nullptr;
};

struct MeasuredScan {
  Scan scan;  // part frame
  ScanCounts counts;
};

Result<MeasuredScan> run_scan(Link& link, const ScanPlan& plan, const ScanOptions& options = {});

// Goes on with the scan of options.journal, which has a plan: fetches what the machine still holds of it, or
// measures what is missing; a scan that was whole already needs nothing of the machine. The result is the
// scan that an undisturbed session would have made. Errors (bad input): the machine or its configuration is
// not the one the scan was begun with.
Result<MeasuredScan> resume_scan(Link& link, const ScanOptions& options);

}  // namespace tetragauge
