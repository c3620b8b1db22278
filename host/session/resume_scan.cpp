// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cstring>

#include "host/session/measure_plan.hpp"
#include "host/session/prepare_machine.hpp"
#include "host/session/run_scan.hpp"
#include "host/session/scan_journal.hpp"

namespace tetragauge {
namespace {

using std::chrono::milliseconds;

// How long a machine whose scan has ended may take to send an item again.
constexpr milliseconds kAnswer{500};

Status check_same_machine(const Link& link, const ScanJournal& journal) {
  const tg_HelloReply &now = link.machine(), &then = journal.plan()->machine;
  const auto differs = [&](const std::string& what, const std::string& was, const std::string& is) {
    return bad_input(journal.path().string() + ": the scan was begun with " + what + " " + was + ", " +
                     link.device() + " has " + is +
                     ": the points would not fit together; connect the machine as it was, or move the " +
                     "journal away and scan anew");
  };
  if (std::strcmp(now.board, then.board) != 0) return differs("board", then.board, now.board);
  if (std::strcmp(now.firmware_version, then.firmware_version) != 0)
    return differs("firmware", then.firmware_version, now.firmware_version);
  if (std::strcmp(now.calibration_id, then.calibration_id) != 0)
    return differs("calibration", then.calibration_id[0] != '\0' ? then.calibration_id : "none",
                   now.calibration_id[0] != '\0' ? now.calibration_id : "none");
  if (now.config_crc != then.config_crc) {
    return differs("configuration", std::to_string(then.config_crc), std::to_string(now.config_crc));
  }
  return Done{};
}

// What the journal holds of one run, into the scan.
struct Replayed {
  StreamSum sum;
  std::optional<tg_ScanEnd> end;
};

Replayed replay(const JournaledRun& run, const RestOfPlan& rest, BeamMerger& merger) {
  Replayed replayed;
  for (const std::string& frame : run.items) {
    const tg_MachineMessage message = message_of_item(frame);
    if (message.which_body == tg_MachineMessage_scan_end_tag) replayed.end = message.body.scan_end;
    if (message.which_body != tg_MachineMessage_points_tag) continue;
    std::array<BeamRecord, kBatchBeams> beams;
    const std::span<const BeamRecord> batch(beams.data(), beams_of_batch(message.body.points, beams.data()));
    replayed.sum.add(batch);
    merger.take(rest, message.body.points, batch);
  }
  return replayed;
}

// Whether the machine still has item `next` of this very scan, or will make it: PAUSED because nobody
// answered, or ended with its last items not fetched.
Result<bool> machine_still_has(Link& link, const JournaledRun& run, uint32_t next) {
  if (link.machine().boot_id != run.boot_id) return false;
  const auto status = link.status();
  if (!status) return status.error();
  if (status->stream_acked > next) return false;
  if (status->state == tg_State_STATE_SCANNING || status->state == tg_State_STATE_PAUSED)
    return status->plan_id == run.plan_id;
  if (status->state != tg_State_STATE_READY || status->stream_next <= next) return false;
  // It has forgotten the plan, but not the items; they say whose they are.
  const auto deadline = std::chrono::steady_clock::now() + kAnswer;
  while (std::chrono::steady_clock::now() < deadline) {
    if (const Status done = ask_again(link, run.plan_id, next, 1); !done) return done.error();
    const auto item = link.next_stream_item(kAnswer / 5);
    if (!item) return item.error();
    if (*item && is_item_of((*item)->message, run.plan_id) && (*item)->number == next) return true;
  }
  return false;
}

// The machine goes on where it was, and sends from item `next` on.
Status wake_up(Link& link, const JournaledRun& run, uint32_t next) {
  if (const Status done = grant_credit(link, run.plan_id, next); !done) return done;
  const auto status = link.status();
  if (!status) return status.error();
  if (status->stream_next > next) {
    const Status asked = ask_again(link, run.plan_id, next, status->stream_next - next);
    if (!asked) return asked;
  }
  if (status->state != tg_State_STATE_PAUSED) return Done{};
  return command(link, tg_HostMessage_scan_resume_tag);
}

}  // namespace

Result<MeasuredScan> resume_scan(Link& link, const ScanOptions& options) {
  const ScanJournal& journal = *options.journal;
  if (const Status same = check_same_machine(link, journal); !same) return same.error();
  const JournaledPlan& plan = *journal.plan();
  ScanBuilder builder(head_geometry(plan.galvo, plan.stage), plan.machine, options);
  BeamMerger merger(plan.views, builder);

  PlanRun last;
  Replayed replayed;
  for (const JournaledRun& run : journal.runs()) {
    last.rest = rest_of_plan(plan.views, run.from, plan.machine.max_views);
    last.plan_id = run.plan_id;
    replayed = replay(run, last.rest, merger);
    last.so_far = replayed.sum;
  }
  if (replayed.end && !replayed.end->aborted && merger.next().view == plan.views.size()) {
    if (const Status good = check_end(link, *replayed.end, replayed.sum); !good) return good.error();
    return std::move(builder.measured);
  }
  if (!journal.runs().empty() && !replayed.end) {
    const JournaledRun& run = journal.runs().back();
    const auto has = machine_still_has(link, run, last.so_far.items);
    if (!has) return has.error();
    if (*has) {
      if (options.log) options.log("the machine still has the scan: goes on");
      if (const Status done = wake_up(link, run, last.so_far.items); !done) return done.error();
      if (const Status done = finish_run(link, plan.views, last, merger, builder, options); !done)
        return done.error();
      return std::move(builder.measured);
    }
  }
  if (options.log)
    options.log("measures what is missing from view " + std::to_string(merger.next().view + 1));
  if (const Status done = prepare_machine(link, options); !done) return done.error();
  if (const Status done = measure_rest(link, plan.views, merger, builder, options); !done)
    return done.error();
  return std::move(builder.measured);
}

}  // namespace tetragauge
