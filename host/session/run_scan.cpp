// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/run_scan.hpp"

#include "host/session/measure_plan.hpp"
#include "host/session/prepare_machine.hpp"
#include "host/session/scan_journal.hpp"

namespace tetragauge {

Result<MeasuredScan> run_scan(Link& link, const ScanPlan& plan, const ScanOptions& options) {
  if (const Status done = prepare_machine(link, options); !done) return done.error();
  const auto config = read_head_config(link);
  if (!config) return config.error();
  const HeadGeometry head = head_geometry(config->galvo, config->stage);

  std::vector<tg_View> views;
  for (const PlannedView& planned : plan.views) {
    const auto view = lay_raster(head, planned);
    if (!view) return view.error();
    views.push_back(*view);
  }
  if (options.journal) {
    const Status kept = options.journal->keep_plan(
        {.machine = link.machine(), .galvo = config->galvo, .stage = config->stage, .views = views});
    if (!kept) return kept.error();
  }
  ScanBuilder builder(head, link.machine(), options);
  BeamMerger merger(views, builder);
  if (const Status done = measure_rest(link, views, merger, builder, options); !done) return done.error();
  return std::move(builder.measured);
}

}  // namespace tetragauge
