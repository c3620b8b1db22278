// SPDX-License-Identifier: GPL-3.0-or-later
// The main job with one part on the table: plan, scan, inspect, and go back to what is in doubt.
//
//   auto part = measure_part(link, model, tolerances);
//   part->run.inspection.verdict, part->scan, part->story
#pragma once

#include "host/measure/improve_scan.hpp"
#include "host/measure/plan_by_survey.hpp"

namespace tetragauge {

// ScanOptions::on_stage gets this while the machine measures; the other stages are the host's own.
inline constexpr const char* kMeasuring = "measuring";

struct MeasureOptions {
  std::optional<ScanPlan> plan;  // the first scan's; without one a coarse scan finds the pose for it
  ImproveOptions improve;
  // Called with the first scan when it is whole, and again when rounds have added to it. An error ends it.
  std::function<Status(const Scan&, const ScanCounts&)> keep_scan{};
};

struct PartMeasurement {
  Scan scan;
  ScanCounts counts;
  InspectionRun run;
  MeasuringStory story;
  // What broke a round off: the machine, or who asked it to stop. All else is whole and judged from what was
  // measured before.
  std::optional<Error> interruption;
};

// With scan.journal that holds a plan already the first scan is gone on with. Errors: what ends a scan
// session (run_scan.hpp), and a scan that cannot be inspected.
Result<PartMeasurement> measure_part(Link& link, const Solid& model, const Tolerances& tolerances,
                                     const MeasureOptions& options = {}, const ScanOptions& scan = {});

}  // namespace tetragauge
