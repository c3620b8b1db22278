// SPDX-License-Identifier: GPL-3.0-or-later
// A plan, or what is left of it, measured by a machine that is homed: the part of a session that run_scan,
// resume_scan and measure_rays share.
#pragma once

#include "host/session/receive_stream.hpp"
#include "host/session/rest_of_plan.hpp"
#include "host/session/scan_builder.hpp"

namespace tetragauge {

// A run of a plan: `rest` is loaded as `plan_id`, its stream comes from item `so_far.items` on.
struct PlanRun {
  RestOfPlan rest;
  uint32_t plan_id = 0;
  StreamSum so_far;
};

// Puts the beams of a run where they belong in the whole plan, and drops what is there already.
class BeamMerger {
 public:
  // `whole` and `builder` must outlive it.
  BeamMerger(std::span<const tg_View> whole, ScanBuilder& builder) : whole_(whole), builder_(builder) {}

  void take(const RestOfPlan& rest, const tg_PointBatch& batch, std::span<const BeamRecord> beams);
  // The first beam that is missing.
  BeamPlace next() const { return next_; }

 private:
  std::span<const tg_View> whole_;
  ScanBuilder& builder_;
  BeamPlace next_;
};

// Loads what is missing after `merger.next()`, starts it, and takes it to its end.
Status measure_rest(Link& link, std::span<const tg_View> whole, BeamMerger& merger, ScanBuilder& builder,
                    const ScanOptions& options);

// Takes the stream of a run that is under way to its end. On an error the machine is told to abort.
Status finish_run(Link& link, std::span<const tg_View> whole, const PlanRun& run, BeamMerger& merger,
                  ScanBuilder& builder, const ScanOptions& options);

// The steps of it. A loaded plan begins:
Status start_scan(Link& link, uint32_t plan_id);
// and is taken to its end: seconds by the machine's clock. On an error the machine is told to abort.
Result<double> take_stream(Link& link, uint32_t plan_id, StreamSum so_far, const ScanOptions& options,
                           const StreamTakers& takers);
// Its end came too early.
Error incomplete_scan(const Link& link);

}  // namespace tetragauge
