// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/hello/bench_actions.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>

namespace tetragauge {
namespace {

using Clock = std::chrono::steady_clock;

Status command(Link& link, const tg_HostMessage& message) {
  auto done = link.request(message);
  return done ? Status(Done{}) : Status(done.error());
}
Status command(Link& link, pb_size_t which) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = which;
  return command(link, message);
}

Status jog(Link& link, tg_AxisName axis, double by) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_jog_tag;
  message.body.jog = {axis, static_cast<int32_t>(std::lround(by))};
  return command(link, message);
}

// The axes stand; a fault that the machine has found on the way is its state, which the caller prints.
Status wait_until_still(Link& link, const std::atomic<bool>& stop) {
  bool stopping = false;
  for (;;) {
    auto status = link.status();
    if (!status) return status.error();
    if (!status->moving && status->state != tg_State_STATE_HOMING) return Done{};
    if (stop && status->state == tg_State_STATE_HOMING) return Done{};
    if (stop && !stopping) {
      if (Status done = command(link, tg_HostMessage_scan_abort_tag); !done) return done;
      stopping = true;
    }
    if (auto frame = link.wait_for_frame(std::chrono::milliseconds(50)); !frame) return frame.error();
  }
}

Status set_laser(Link& link, bool on) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_laser_set_tag;
  message.body.laser_set.on = on;
  return command(link, message);
}

bool runs(tg_State state) {
  return state == tg_State_STATE_SCANNING || state == tg_State_STATE_PAUSED;
}

}  // namespace

Status end_what_runs(Link& link) {
  auto status = link.status();
  if (!status) return status.error();
  if (!runs(status->state)) return Done{};
  // The machine keeps a scan's end back until there is room for it.
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_points_credit_tag;
  message.body.points_credit = {status->plan_id, status->stream_next, status->stream_next};
  if (Status done = link.send_event(message); !done) return done;
  if (Status done = command(link, tg_HostMessage_scan_abort_tag); !done) return done;
  const auto ends = Clock::now() + link.silence();
  while (Clock::now() < ends) {
    status = link.status();
    if (!status) return status.error();
    if (!runs(status->state)) return command(link, tg_HostMessage_scan_abort_tag);  // what nobody fetched
    if (auto frame = link.wait_for_frame(std::chrono::milliseconds(20)); !frame) return frame.error();
  }
  return machine_error(link.device() + ": the machine does not end what an earlier host began; press reset");
}

Status run_actions(Link& link, const BenchActions& actions, const std::atomic<bool>& stop) {
  if (Status ended = end_what_runs(link); !ended) return ended;
  // A move of an earlier host.
  if (Status still = wait_until_still(link, stop); !still) return still;
  auto status = link.status();
  if (!status) return status.error();
  if (status->state == tg_State_STATE_FAULT || status->state == tg_State_STATE_ESTOP) {
    if (Status done = command(link, tg_HostMessage_clear_fault_tag); !done) return done;
  }
  if (actions.home && !stop) {
    if (Status done = command(link, tg_HostMessage_home_tag); !done) return done;
    if (Status still = wait_until_still(link, stop); !still) return still;
  }
  // Micrometres and microdegrees.
  if (actions.table_deg && !stop) {
    if (Status done = jog(link, tg_AxisName_AXIS_TABLE, *actions.table_deg * 1e6); !done) return done;
    if (Status still = wait_until_still(link, stop); !still) return still;
  }
  if (actions.slide_mm && !stop) {
    if (Status done = jog(link, tg_AxisName_AXIS_SLIDE, *actions.slide_mm * 1e3); !done) return done;
    if (Status still = wait_until_still(link, stop); !still) return still;
  }
  if (actions.mirrors_urad && !stop) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_move_galvo_tag;
    message.body.move_galvo = {actions.mirrors_urad->first, actions.mirrors_urad->second};
    if (Status done = command(link, message); !done) return done;
  }
  if (actions.laser_s <= 0 || stop) return Done{};
  link.forget_fault();
  if (Status on = set_laser(link, true); !on) return on;
  std::fprintf(stderr, "the laser is on for %g s; Ctrl-C turns it off\n", actions.laser_s);
  // Answers heartbeats: without a host the machine would turn the light off by itself.
  const auto ends = Clock::now() + std::chrono::duration<double>(actions.laser_s);
  while (Clock::now() < ends && !stop && !link.fault()) {
    if (auto frame = link.wait_for_frame(std::chrono::milliseconds(50)); !frame) return frame.error();
  }
  // After a fault it is off already.
  return link.fault() ? Status(Done{}) : set_laser(link, false);
}

}  // namespace tetragauge
