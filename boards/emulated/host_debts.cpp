// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/host_debts.hpp"

#include <algorithm>

namespace tetragauge {

void HostDebts::host_said(std::span<const uint8_t> bytes) {
  for (const uint8_t byte : bytes) {
    if (from_host_.push(byte)) take_from_host(from_host_.frame());
  }
}

void HostDebts::take_from_host(const Frame& frame) {
  if (!decode_message(frame, &said_)) return;
  if (frame.header.channel == Channel::kEvent) {
    take_event(said_);
    return;
  }
  switch (said_.which_body) {
    case tg_HostMessage_hello_tag:
      answered_ = heartbeat_;
      [[fallthrough]];
    case tg_HostMessage_scan_load_tag:
    case tg_HostMessage_measure_rays_tag:
    case tg_HostMessage_scan_abort_tag:
      // The stream starts anew, or is no longer listened to.
      streaming_ = asked_ = asks_again_due_ = knows_of_gap_ = false;
      break;
    default:
      break;
  }
}

void HostDebts::take_event(const tg_HostMessage& message) {
  switch (message.which_body) {
    case tg_HostMessage_heartbeat_ack_tag:
      answered_ = message.body.heartbeat_ack.counter;
      break;
    case tg_HostMessage_points_credit_tag: {
      const uint32_t acked = message.body.points_credit.acked;
      // What it says about itself is better than what was concluded from the line, and so is saying it twice.
      if (!streaming_ || acked == acked_ || acked > host_next_) host_next_ = acked;
      if (!streaming_ || acked > acked_) asked_ = false;
      streaming_ = true;
      acked_ = acked;
      break;
    }
    case tg_HostMessage_points_resend_tag:
      asked_ = true;
      asks_again_due_ = knows_of_gap_ = false;
      break;
    default:
      break;
  }
}

void HostDebts::reached_host(uint8_t byte) {
  if (!to_host_.push(byte)) return;
  arrived_whole_ = true;
  const Frame& frame = to_host_.frame();
  if (frame.header.channel == Channel::kStream && streaming_) {
    if (frame.header.id == host_next_) {
      ++host_next_;
    } else if (frame.header.id > host_next_) {
      asks_again_due_ = !asked_;
    }
  } else if (frame.header.channel == Channel::kEvent && decode_message(frame, &told_) &&
             told_.which_body == tg_MachineMessage_heartbeat_tag) {
    const tg_Heartbeat& heartbeat = told_.body.heartbeat;
    heartbeat_ = heartbeat.counter;
    const bool behind = streaming_ && heartbeat.stream_next > host_next_;
    knows_of_gap_ = behind && !asked_;
    news_lost_ = news_lost_ && behind;
  }
}

void HostDebts::frame_ended() {
  if (!arrived_whole_) news_lost_ = true;
  arrived_whole_ = false;
}

}  // namespace tetragauge
