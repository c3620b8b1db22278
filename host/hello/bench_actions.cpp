// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/hello/bench_actions.hpp"

#include <chrono>
#include <cmath>

namespace tetragauge {
namespace {

using Clock = std::chrono::steady_clock;

Status jog(Link& link, tg_AxisName axis, double by) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_jog_tag;
  message.body.jog = {axis, static_cast<int32_t>(std::lround(by))};
  auto done = link.request(message);
  return done ? Status(Done{}) : Status(done.error());
}

// The axes stand; a fault that the machine has found on the way is its state, which the caller prints.
Status wait_until_still(Link& link) {
  for (;;) {
    auto status = link.status();
    if (!status) return status.error();
    if (!status->moving && status->state != tg_State_STATE_HOMING) return Done{};
    if (auto frame = link.wait_for_frame(std::chrono::milliseconds(50)); !frame) return frame.error();
  }
}

Status set_laser(Link& link, bool on) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  message.which_body = tg_HostMessage_laser_set_tag;
  message.body.laser_set.on = on;
  auto done = link.request(message);
  return done ? Status(Done{}) : Status(done.error());
}

}  // namespace

Status run_actions(Link& link, const BenchActions& actions) {
  tg_HostMessage message = tg_HostMessage_init_zero;
  auto status = link.status();
  if (!status) return status.error();
  if (status->state == tg_State_STATE_FAULT || status->state == tg_State_STATE_ESTOP) {
    message.which_body = tg_HostMessage_clear_fault_tag;
    if (auto done = link.request(message); !done) return done.error();
  }
  if (actions.home) {
    message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_home_tag;
    if (auto done = link.request(message); !done) return done.error();
    if (Status still = wait_until_still(link); !still) return still;
  }
  // Micrometres and microdegrees.
  if (actions.table_deg) {
    if (Status done = jog(link, tg_AxisName_AXIS_TABLE, *actions.table_deg * 1e6); !done) return done;
    if (Status still = wait_until_still(link); !still) return still;
  }
  if (actions.slide_mm) {
    if (Status done = jog(link, tg_AxisName_AXIS_SLIDE, *actions.slide_mm * 1e3); !done) return done;
    if (Status still = wait_until_still(link); !still) return still;
  }
  if (actions.mirrors_urad) {
    message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_move_galvo_tag;
    message.body.move_galvo = {actions.mirrors_urad->first, actions.mirrors_urad->second};
    if (auto done = link.request(message); !done) return done.error();
  }
  if (actions.laser_s <= 0) return Done{};
  if (Status on = set_laser(link, true); !on) return on;
  // Answers heartbeats: without a host the machine would turn the light off by itself.
  const auto ends = Clock::now() + std::chrono::duration<double>(actions.laser_s);
  while (Clock::now() < ends) {
    if (auto frame = link.wait_for_frame(std::chrono::milliseconds(50)); !frame) return frame.error();
  }
  return set_laser(link, false);
}

}  // namespace tetragauge
