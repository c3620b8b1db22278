// SPDX-License-Identifier: Apache-2.0
// Frames in and out of the board's byte line. One frame is on its way out at a time; what goes next: a reply,
// a fault, a heartbeat, a stream item.
#pragma once

#include "firmware/hal/board.hpp"
#include "firmware/link/obligations.hpp"
#include "firmware/link/reply_cache.hpp"
#include "firmware/link/stream_ring.hpp"

namespace tetragauge {

inline constexpr uint64_t kHeartbeatNs = 100'000'000;

template <Board B>
class HostLink {
 public:
  HostLink(B& board, StreamRing& ring) : board_(board), ring_(ring) {}

  // True when a good frame came; frame() is valid until the next call. While a reply waits to be sent no more
  // is read.
  bool receive() {
    while (reply_bytes_ == 0) {
      if (read_at_ == read_end_) {
        read_at_ = 0;
        read_end_ = board_.read(input_, sizeof input_);
        if (read_end_ == 0) return false;
      }
      while (read_at_ < read_end_) {
        if (reader_.push(input_[read_at_++])) return true;
      }
    }
    return false;
  }
  const Frame& frame() const { return reader_.frame(); }
  uint32_t bad_frames() const { return reader_.bad_frames(); }

  // The answer given before to this very request is sent again.
  bool replied_before(const Frame& request) {
    const uint8_t* wire = cache_.find(request.header.id, crc_of(request), &reply_bytes_);
    if (wire != nullptr) reply_ = wire;
    return wire != nullptr;
  }
  void reply(const Frame& request, const tg_MachineMessage& message) {
    reply_ = cache_.store(request.header.id, crc_of(request), message, &reply_bytes_);
  }
  void forget_replies() { cache_.forget(); }

  void start_heartbeats() {
    if (!heartbeats_) next_heartbeat_ns_ = board_.now_ns() + kHeartbeatNs;
    heartbeats_ = true;
  }
  bool heartbeat_due() const { return heartbeats_ && board_.now_ns() >= next_heartbeat_ns_; }
  uint64_t next_heartbeat_ns() const { return heartbeats_ ? next_heartbeat_ns_ : ~uint64_t{0}; }

  // The caller has filled in all but the counter. A heartbeat that still waits is replaced.
  void heartbeat(tg_Heartbeat heartbeat) {
    next_heartbeat_ns_ += kHeartbeatNs;
    // After a long stop the missed ones are not made up for.
    if (next_heartbeat_ns_ <= board_.now_ns()) next_heartbeat_ns_ = board_.now_ns() + kHeartbeatNs;
    heartbeat.counter = ++heartbeat_counter_;
    event_ = tg_MachineMessage_init_zero;
    event_.which_body = tg_MachineMessage_heartbeat_tag;
    event_.body.heartbeat = heartbeat;
    heartbeat_bytes_ = encode_message({Channel::kEvent, event_count_++}, event_, heartbeat_wire_);
  }

  void fault(const tg_Fault& fault) {
    event_ = tg_MachineMessage_init_zero;
    event_.which_body = tg_MachineMessage_fault_tag;
    event_.body.fault = fault;
    fault_bytes_ = encode_message({Channel::kEvent, event_count_++}, event_, fault_wire_);
  }

  void send() {
    for (;;) {
      if (out_at_ == out_bytes_ && !next_frame()) return;
      const size_t taken = board_.write(out_ + out_at_, out_bytes_ - out_at_);
      if (taken == 0) return;
      out_at_ += taken;
      if (out_at_ < out_bytes_) continue;
      if (out_is_item_) obligations_.item_sent(ring_.sent());
      if (out_is_heartbeat_) obligations_.heartbeat_sent(heartbeat_counter_);
    }
  }
  bool sending() const { return out_at_ < out_bytes_ || reply_bytes_ + fault_bytes_ + heartbeat_bytes_ > 0; }

  Obligations& obligations() { return obligations_; }
  const Obligations& obligations() const { return obligations_; }

 private:
  static uint32_t crc_of(const Frame& frame) { return crc32c(frame.payload, frame.payload_bytes); }

  bool next_frame() {
    out_is_item_ = out_is_heartbeat_ = false;
    uint32_t item = 0;
    if (reply_bytes_ > 0) {
      put_out(reply_, &reply_bytes_);
    } else if (fault_bytes_ > 0) {
      put_out(fault_wire_, &fault_bytes_);
    } else if (heartbeat_bytes_ > 0) {
      out_is_heartbeat_ = true;
      put_out(heartbeat_wire_, &heartbeat_bytes_);
    } else if (ring_.next_to_send(&item)) {
      out_is_item_ = true;
      out_bytes_ = ring_.encode(item, out_);
      out_at_ = 0;
    } else {
      return false;
    }
    return true;
  }

  // Copied, so that its place is free for the next one while it goes out.
  void put_out(const uint8_t* wire, size_t* bytes) {
    for (size_t i = 0; i < *bytes; ++i) out_[i] = wire[i];
    out_bytes_ = *bytes;
    out_at_ = 0;
    *bytes = 0;
  }

  B& board_;
  StreamRing& ring_;
  FrameReader reader_;
  uint8_t input_[64] = {};
  size_t read_at_ = 0, read_end_ = 0;

  ReplyCache cache_;
  const uint8_t* reply_ = nullptr;
  size_t reply_bytes_ = 0;

  tg_MachineMessage event_ = tg_MachineMessage_init_zero;
  uint32_t event_count_ = 0;
  uint8_t fault_wire_[kFrameWireBytes] = {}, heartbeat_wire_[kFrameWireBytes] = {};
  size_t fault_bytes_ = 0, heartbeat_bytes_ = 0;
  bool heartbeats_ = false;
  uint64_t next_heartbeat_ns_ = 0;
  uint32_t heartbeat_counter_ = 0;

  uint8_t out_[kFrameWireBytes] = {};
  size_t out_at_ = 0, out_bytes_ = 0;
  bool out_is_item_ = false, out_is_heartbeat_ = false;
  Obligations obligations_;
};

}  // namespace tetragauge
