// SPDX-License-Identifier: Apache-2.0
// Frames in and out of the board's byte line. One frame is on its way out at a time; what goes next: a reply,
// a fault, a heartbeat, a log line, a stream item.
#pragma once

#include "firmware/hal/board.hpp"
#include "firmware/link/log_queue.hpp"
#include "firmware/link/reply_cache.hpp"
#include "firmware/link/stream_ring.hpp"

namespace tetragauge {

inline constexpr uint64_t kHeartbeatNs = 100'000'000;

template <Board B>
class HostLink {
 public:
  // `outgoing`: where an event is made.
  HostLink(B& board, StreamRing& ring, tg_MachineMessage& outgoing)
      : board_(board), ring_(ring), event_(outgoing) {}

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
        if (!reader_.push(input_[read_at_++])) continue;
        ++frames_in_;
        return true;
      }
    }
    return false;
  }
  const Frame& frame() const { return reader_.frame(); }
  uint32_t bad_frames() const { return reader_.bad_frames(); }
  uint32_t frames_in() const { return frames_in_; }
  uint32_t frames_out() const { return frames_out_; }
  uint32_t repeated_requests() const { return repeated_requests_; }
  uint32_t logs_dropped() const { return logs_.dropped(); }

  // The answer given before to this very request is sent again; one whose answer is still being worked out
  // gets it then.
  bool replied_before(const Frame& request) {
    const uint32_t crc = crc_of(request);
    const bool pending = reply_pending_ && pending_id_ == request.header.id && pending_crc_ == crc;
    const uint8_t* wire = cache_.find(request.header.id, crc, &reply_bytes_);
    if (wire != nullptr) reply_ = wire;
    if (wire == nullptr && !pending) return false;
    ++repeated_requests_;
    return true;
  }
  void reply(const Frame& request, const tg_MachineMessage& message) {
    reply_ = cache_.store(request.header.id, crc_of(request), message, &reply_bytes_);
  }
  // A request that takes time: at most one. Its reply goes out with reply_to_pending(), which must wait while
  // an earlier reply is on its way (can_reply).
  void answer_later(const Frame& request) {
    reply_pending_ = true;
    pending_id_ = request.header.id;
    pending_crc_ = crc_of(request);
  }
  bool can_reply() const { return reply_bytes_ == 0; }
  void reply_to_pending(const tg_MachineMessage& message) {
    reply_pending_ = false;
    reply_ = cache_.store(pending_id_, pending_crc_, message, &reply_bytes_);
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

  // `text` is a literal. Kept until a host is there; the newest are dropped, and counted, when it does not
  // listen.
  void log(tg_LogLevel level, const char* text) { logs_.add(level, board_.now_ns() / 1000, text); }

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
      ++frames_out_;
    }
  }
  bool sending() const {
    return out_at_ < out_bytes_ || reply_bytes_ + fault_bytes_ + heartbeat_bytes_ > 0 || log_waits();
  }

 private:
  bool log_waits() const { return heartbeats_ && !logs_.empty(); }

  static uint32_t crc_of(const Frame& frame) { return crc32c(frame.payload, frame.payload_bytes); }

  bool next_frame() {
    uint32_t item = 0;
    if (reply_bytes_ > 0) {
      put_out(reply_, &reply_bytes_);
    } else if (fault_bytes_ > 0) {
      put_out(fault_wire_, &fault_bytes_);
    } else if (heartbeat_bytes_ > 0) {
      put_out(heartbeat_wire_, &heartbeat_bytes_);
    } else if (log_waits()) {
      event_ = tg_MachineMessage_init_zero;
      event_.which_body = tg_MachineMessage_log_tag;
      logs_.take(&event_.body.log);
      out_bytes_ = encode_message({Channel::kEvent, event_count_++}, event_, out_);
      out_at_ = 0;
    } else if (ring_.next_to_send(&item)) {
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

  uint32_t frames_in_ = 0, frames_out_ = 0, repeated_requests_ = 0;

  ReplyCache cache_;
  bool reply_pending_ = false;
  uint32_t pending_id_ = 0, pending_crc_ = 0;
  const uint8_t* reply_ = nullptr;
  size_t reply_bytes_ = 0;

  LogQueue logs_;
  tg_MachineMessage& event_;
  uint32_t event_count_ = 0;
  uint8_t fault_wire_[wire_bytes_of(tg_Fault_size)] = {};
  uint8_t heartbeat_wire_[wire_bytes_of(tg_Heartbeat_size)] = {};
  size_t fault_bytes_ = 0, heartbeat_bytes_ = 0;
  bool heartbeats_ = false;
  uint64_t next_heartbeat_ns_ = 0;
  uint32_t heartbeat_counter_ = 0;

  uint8_t out_[kFrameWireBytes] = {};
  size_t out_at_ = 0, out_bytes_ = 0;
};

}  // namespace tetragauge
