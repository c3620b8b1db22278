// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/measure_plan.hpp"

#include <array>

#include "host/session/load_plan.hpp"
#include "host/session/prepare_machine.hpp"
#include "host/session/scan_journal.hpp"

namespace tetragauge {

Status start_scan(Link& link, uint32_t plan_id) {
  if (const Status done = grant_credit(link, plan_id, 0); !done) return done;
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_scan_start_tag;
  message.body.scan_start.plan_id = plan_id;
  const auto reply = link.request(message);
  if (!reply) return reply.error();
  return Done{};
}

Result<double> take_stream(Link& link, uint32_t plan_id, StreamSum so_far, const ScanOptions& options,
                           const StreamTakers& takers) {
  const auto before = link.status();
  if (!before) return before.error();
  const auto end = receive_stream(link, plan_id, so_far, options, takers);
  if (!end) {
    // The laser must not stay on; a machine that can be reached is told, one that cannot pauses by itself.
    // The first error is the one that counts.
    if (link.silent_for() < link.silence()) (void)command(link, tg_HostMessage_scan_abort_tag);
    return end.error();
  }
  return 1e-6 * static_cast<double>(end->clock_us - before->clock_us);
}

Error incomplete_scan(const Link& link) {
  return machine_error(link.device() + ": the machine ended the scan before the plan's last beam; flash " +
                       "firmware of this version");
}

void BeamMerger::take(const RestOfPlan& rest, const tg_PointBatch& batch, std::span<const BeamRecord> beams) {
  std::array<BeamRecord, kBatchBeams> missing;
  size_t count = 0;
  for (const BeamRecord& beam : beams) {
    const auto place = place_in_whole(rest, {beam.view, beam.ray});
    if (!place || *place != next_) continue;
    missing[count] = beam;
    missing[count].view = place->view;
    missing[count].ray = place->ray;
    ++count;
    ++next_.ray;
    if (next_.ray == whole_[next_.view].columns * whole_[next_.view].rows) next_ = {next_.view + 1, 0};
    if (next_.view == whole_.size()) break;
  }
  builder_.take(batch, {missing.data(), count});
}

Status finish_run(Link& link, std::span<const tg_View> whole, const PlanRun& run, BeamMerger& merger,
                  ScanBuilder& builder, const ScanOptions& options) {
  size_t beams_planned = 0;
  for (const tg_View& view : whole) beams_planned += size_t{view.columns} * view.rows;
  const size_t beams_before = builder.measured.counts.beams;

  StreamTakers takers;
  if (options.journal) {
    takers.keep = [&](const tg_MachineMessage& item) { return options.journal->keep_item(item); };
  }
  takers.take = [&](const tg_PointBatch& batch, std::span<const BeamRecord> beams) {
    merger.take(run.rest, batch, beams);
    if (!options.on_progress) return;
    options.on_progress({.view = std::min<size_t>(merger.next().view + 1, whole.size()),
                         .views = whole.size(),
                         .beams_planned = beams_planned,
                         .beams_resumed = beams_before,
                         .counts = builder.measured.counts});
  };
  const auto time_s = take_stream(link, run.plan_id, run.so_far, options, takers);
  if (!time_s) return time_s.error();
  if (merger.next().view != whole.size()) return incomplete_scan(link);
  ScanCounts& counts = builder.measured.counts;
  counts.machine_time_s = *time_s;
  counts.timed_beams = counts.beams - beams_before;
  return Done{};
}

Status measure_rest(Link& link, std::span<const tg_View> whole, BeamMerger& merger, ScanBuilder& builder,
                    const ScanOptions& options) {
  PlanRun run;
  run.rest = rest_of_plan(whole, merger.next(), link.machine().max_views);
  if (run.rest.views.empty()) return Done{};
  run.plan_id = plan_id_of(run.rest.views);
  if (const Status done = load_plan(link, run.plan_id, run.rest.views); !done) return done;
  if (options.journal) {
    const Status kept = options.journal->keep_run(
        {.boot_id = link.machine().boot_id, .plan_id = run.plan_id, .from = run.rest.from, .items = {}});
    if (!kept) return kept;
  }
  if (const Status done = start_scan(link, run.plan_id); !done) return done;
  return finish_run(link, whole, run, merger, builder, options);
}

}  // namespace tetragauge
