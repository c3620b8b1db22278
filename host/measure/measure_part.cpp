// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/measure/measure_part.hpp"

#include <algorithm>

#include "host/session/scan_journal.hpp"

namespace tetragauge {
namespace {

// The first scan, by the plan there is or one that is found.
Result<MeasuredScan> first_scan(Link& link, const PlanningMachine& machine, const Solid& model,
                                const RayCaster& caster, const MeasureOptions& options,
                                const ScanOptions& scan, MeasuringStory& story) {
  const auto say_measuring = [&] {
    if (scan.on_stage) scan.on_stage(kMeasuring);
  };
  if (scan.journal && scan.journal->plan()) {
    say_measuring();
    story.plan = "that of the interrupted scan, gone on with";
    return resume_scan(link, scan);
  }
  if (options.plan) {
    say_measuring();
    story.plan = "as given";
    return run_scan(link, *options.plan, scan);
  }
  const auto found =
      plan_by_survey(link, machine, model, caster, options.improve.inspect, options.improve.plan, scan);
  if (!found) return found.error();
  story.plan = found->how;
  if (scan.log) scan.log("plan: " + found->how);
  say_measuring();
  return run_scan(link, found->scan, scan);
}

}  // namespace

Result<PartMeasurement> measure_part(Link& link, const Solid& model, const Tolerances& tolerances,
                                     const MeasureOptions& options, const ScanOptions& scan) {
  const auto machine = read_machine(link);
  if (!machine) return machine.error();
  const RayCaster caster(model);
  ImproveOptions improve = options.improve;
  improve.inspect.on_stage = scan.on_stage;
  improve.inspect.reconstruct.keep_tetrahedra = improve.rounds > 0;
  PartMeasurement out;
  auto first = first_scan(link, *machine, model, caster, options, scan, out.story);
  if (!first) return first.error();
  const auto keep = [&](const Scan& measured, const ScanCounts& counts) -> Status {
    if (!options.keep_scan) return Done{};
    if (scan.on_stage) scan.on_stage("keeping the scan");
    return options.keep_scan(measured, counts);
  };
  if (const Status kept = keep(first->scan, first->counts); !kept) return kept.error();

  Result<InspectionRun> run = inspect(first->scan, model, tolerances, improve.inspect);
  if (!run) return run.error();
  PartInProgress part{std::move(first->scan), first->counts, 0, std::move(*run)};
  for (const uint32_t view : part.scan.view) part.views = std::max(part.views, view + 1);
  for (const RejectedBeam& beam : part.scan.rejected) part.views = std::max(part.views, beam.view + 1);
  if (improve.rounds > 0) {
    out.interruption =
        improve_scan(link, *machine, model, caster, tolerances, improve, scan, part, out.story);
    if (!out.story.rounds.empty())
      if (const Status kept = keep(part.scan, part.counts); !kept) return kept.error();
  }
  out.scan = std::move(part.scan);
  out.counts = part.counts;
  out.run = std::move(part.run);
  return out;
}

}  // namespace tetragauge
