// SPDX-License-Identifier: GPL-3.0-or-later
// A whole scan session with a machine, real or emulated:
//
//   auto plan = default_plan(link);              // or read_plan(path)
//   auto measured = run_scan(link, *plan);
//   write_scan("scan.ply", measured->scan);
//
// Homes the machine if need be, loads the plan, measures, takes every beam in order (asking again for what
// got lost), and compares count and checksum with the machine's own. On any error, and when asked to stop,
// the machine is told to abort (laser off) and there is no scan.
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

struct ScanProgress {
  size_t view = 0, views = 0;  // view: from 1
  size_t points = 0, rejected = 0, beams = 0, beams_planned = 0;
};

struct ScanOptions {
  bool keep_table = false;                                 // keep points on the table's top
  std::optional<uint64_t> seed{};                          // of an emulated machine, for the scan's header
  const std::atomic<bool>* stop = nullptr;                 // set (Ctrl-C): abort
  std::function<void(const ScanProgress&)> on_progress{};  // after each batch
  std::function<void(const std::string&)> log{};           // what the session does, one line each
};

struct ScanCounts {
  size_t beams = 0, points = 0;
  size_t table_points = 0;               // dropped: on the table's top
  size_t unsettled = 0, one_camera = 0;  // of the points kept
  std::array<size_t, 8> rejected{};      // by tg_RejectReason
  double machine_time_s = 0;             // from start to end by the machine's clock
};

struct MeasuredScan {
  Scan scan;  // part frame
  ScanCounts counts;
};

Result<MeasuredScan> run_scan(Link& link, const ScanPlan& plan, const ScanOptions& options = {});

}  // namespace tetragauge
