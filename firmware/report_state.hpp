// SPDX-License-Identifier: Apache-2.0
// What the machine says of itself: HelloReply, Status, Heartbeat, Stats.
#pragma once

#include "firmware/machine.hpp"
#include "firmware/version.hpp"
#include "protocol/schema_hash.hpp"

namespace tetragauge {

inline void copy_text(char* to, size_t size, const char* from) {
  size_t i = 0;
  for (; i + 1 < size && from[i] != '\0'; ++i) to[i] = from[i];
  to[i] = '\0';
}

template <Board B>
void report_hello(const Machine<B>& machine, tg_HelloReply& hello) {
  hello.protocol_version = kProtocolVersion;
  hello.schema_hash = kSchemaHash;
  copy_text(hello.firmware_version, sizeof hello.firmware_version, kFirmwareVersion);
  copy_text(hello.board, sizeof hello.board, B::kName);
  hello.capabilities = B::kCapabilities;
  hello.boot_id = machine.board.boot_id();
  hello.state = machine.state();
  hello.max_views = kMaxViews;
  hello.config_crc = machine.config_crc;
  hello.sample_period_ns = B::kSamplePeriodNs;
  hello.ring_items = kRingItems;
  hello.max_listed_rays = kMaxListedRays;
  hello.reset_cause = machine.board.reset_cause();
  if (machine.calibrated()) {
    copy_text(hello.calibration_id, sizeof hello.calibration_id, machine.claim.id);
    hello.u_cal_100nm = machine.claim.u_cal_100nm;
  }
}

template <Board B>
void report_status(Machine<B>& machine, tg_Status& status) {
  status.state = machine.state();
  status.fault = machine.supervisor.fault();
  status.fault_clock_us = machine.supervisor.fault_clock_us();
  status.clock_us = machine.board.now_ns() / 1000;
  machine.board.mask_interrupts(true);  // a step in between would tear a 64-bit position
  const int64_t table_at = machine.table.position_steps(), slide_at = machine.slide.position_steps();
  machine.board.mask_interrupts(false);
  status.table_udeg = table_udeg(machine.config, table_at);
  status.slide_um = slide_um(machine.config, slide_at);
  status.homed = machine.homed;
  status.inputs = machine.board.inputs();
  status.plan_id = machine.plan.plan_id();
  status.views_loaded = machine.plan.views_loaded();
  status.view = machine.scan.view();
  status.ray = machine.scan.ray();
  status.stream_next = machine.ring.next_item();
  status.stream_acked = machine.ring.acked();
  status.bad_frames = machine.link.bad_frames();
  status.config_crc = machine.config_crc;
  status.home_spread_table_udeg =
      static_cast<uint32_t>(table_udeg(machine.config, machine.table.home_spread_steps()));
  status.home_spread_slide_um =
      static_cast<uint32_t>(slide_um(machine.config, machine.slide.home_spread_steps()));
  status.moving = machine.moving();
  status.aiming = machine.aiming;
  status.a_urad = machine.scan.a_urad();
  status.b_urad = machine.scan.b_urad();
}

template <Board B>
tg_Heartbeat report_heartbeat(const Machine<B>& machine) {
  tg_Heartbeat beat = tg_Heartbeat_init_zero;
  beat.state = machine.state();
  beat.fault = machine.supervisor.fault();
  beat.clock_us = machine.board.now_ns() / 1000;
  beat.plan_id = machine.ring.plan_id();
  beat.stream_next = machine.ring.sent();
  beat.view = machine.scan.view();
  beat.views = machine.plan.views();
  return beat;
}

template <Board B>
void report_stats(const Machine<B>& machine, tg_Stats& stats) {
  const auto& tally = machine.scan.tally();
  stats.clock_us = machine.board.now_ns() / 1000;
  stats.frames_in = machine.link.frames_in();
  stats.bad_frames = machine.link.bad_frames();
  stats.frames_out = machine.link.frames_out();
  stats.repeated_requests = machine.link.repeated_requests();
  stats.items_resent = machine.ring.items_resent();
  stats.ring_most = machine.ring.most_kept();
  stats.points = tally.points;
  stats.rejected_count = _tg_RejectReason_MAX + 1;
  static_assert(_tg_RejectReason_MAX < kRejectReasons &&
                kRejectReasons * sizeof(uint32_t) == sizeof stats.rejected);
  for (uint32_t reason = 0; reason < stats.rejected_count; ++reason)
    stats.rejected[reason] = tally.rejected[reason];
  stats.unsettled = tally.unsettled;
  stats.silences = machine.silences;
  stats.faults = machine.faults;
  stats.logs_dropped = machine.link.logs_dropped();
  stats.stack_free_bytes = machine.board.stack_free_bytes();
  stats.longest_poll_us = machine.longest_poll_us;
  stats.steps_late = machine.table.steps_late() + machine.slide.steps_late();
}

}  // namespace tetragauge
