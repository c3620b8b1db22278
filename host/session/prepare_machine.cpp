// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/prepare_machine.hpp"

#include "host/link/explain.hpp"
#include "host/session/show_machine_log.hpp"

namespace tetragauge {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPoll{200};

void say(const ScanOptions& options, const std::string& line) {
  if (options.log) options.log(line);
}

// Ends a scan of an earlier session. Its points are given up first: the machine keeps the end of the scan
// back until there is room for it.
Status end_old_scan(Link& link, const tg_Status& status) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_points_credit_tag;
  message.body.points_credit = {status.plan_id, status.stream_next, status.stream_next};
  if (const Status done = link.send_event(message); !done) return done;
  if (const Status done = command(link, tg_HostMessage_scan_abort_tag); !done) return done;
  const auto deadline = std::chrono::steady_clock::now() + link.silence();
  while (std::chrono::steady_clock::now() < deadline) {
    const auto now = link.status();
    if (!now) return now.error();
    if (now->state != tg_State_STATE_SCANNING && now->state != tg_State_STATE_PAUSED) return Done{};
    const auto heard = link.wait_for_frame(milliseconds(20));
    if (!heard) return heard.error();
  }
  return machine_error(link.device() +
                       ": the machine does not end the scan of an earlier session; switch it off and on");
}

Status wait_until_homed(Link& link, const ScanOptions& options) {
  for (;;) {
    if (options.stop && *options.stop) {
      // Homing has the laser off and ends by itself.
      return machine_error(link.device() + ": stopped while homing; the laser is off");
    }
    if (link.fault()) return link.fault_error(link.fault()->code, link.fault()->detail);
    const auto status = link.status();
    show_machine_log(link, options);
    if (!status) return status.error();
    if (status->state == tg_State_STATE_FAULT || status->state == tg_State_STATE_ESTOP) {
      return link.fault_error(status->fault, "");
    }
    if (status->state != tg_State_STATE_HOMING) return Done{};
    const auto heard = link.wait_for_frame(kPoll);
    if (!heard) return heard.error();
    if (link.silent_for() >= link.silence()) return link.silence_error();
  }
}

}  // namespace

Status command(Link& link, pb_size_t which) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = which;
  const auto reply = link.request(message);
  if (!reply) return reply.error();
  return Done{};
}

Status prepare_machine(Link& link, const ScanOptions& options) {
  auto status = link.status();
  show_machine_log(link, options);
  if (!status) return status.error();
  if (status->state == tg_State_STATE_SCANNING || status->state == tg_State_STATE_PAUSED) {
    say(options, "the machine still has a scan of an earlier session: aborted");
    if (const Status done = end_old_scan(link, *status); !done) return done;
    status = link.status();
    if (!status) return status.error();
  }
  if (status->state == tg_State_STATE_FAULT || status->state == tg_State_STATE_ESTOP) {
    say(options, "clears a fault of an earlier session: " + std::string(explain_fault(status->fault)));
    if (const Status done = command(link, tg_HostMessage_clear_fault_tag); !done) {
      return link.fault_error(status->fault, "");
    }
    link.forget_fault();
    status = link.status();
    if (!status) return status.error();
  }
  if (status->state == tg_State_STATE_READY || status->state == tg_State_STATE_ARMED) {
    // Drops an earlier plan and what nobody fetched of it.
    return command(link, tg_HostMessage_scan_abort_tag);
  }
  if (status->state == tg_State_STATE_HOMING) return wait_until_homed(link, options);
  say(options, "homing");
  if (const Status done = command(link, tg_HostMessage_home_tag); !done) return done;
  return wait_until_homed(link, options);
}

Result<HeadConfig> read_head_config(Link& link) {
  const auto galvo = link.config(tg_ConfigPart_CONFIG_GALVO);
  if (!galvo) return galvo.error();
  const auto stage = link.config(tg_ConfigPart_CONFIG_STAGE);
  if (!stage) return stage.error();
  if (galvo->which_part != tg_Config_galvo_tag || stage->which_part != tg_Config_stage_tag) {
    return machine_error(link.device() +
                         ": the machine sent another part of its configuration than was asked for; "
                         "flash firmware of this version");
  }
  return HeadConfig{galvo->part.galvo, stage->part.stage};
}

}  // namespace tetragauge
