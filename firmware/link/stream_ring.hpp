// SPDX-License-Identifier: Apache-2.0
// Stream items (point batches, scan end) kept until the host has acknowledged them, with credit and resend.
// An item is kept as its encoded payload, so that a resend is the same bytes.
#pragma once

#include <cstdint>

#include "protocol/message.hpp"

namespace tetragauge {

inline constexpr uint32_t kRingItems = 32;

class StreamRing {
 public:
  void start(uint32_t plan_id);
  uint32_t plan_id() const { return plan_id_; }

  bool full() const { return next_ - acked_ == kRingItems; }
  // The ring is not full. False when the message does not fit a frame.
  bool push(const tg_MachineMessage& item);

  // From the host; whatever is out of range or of another plan changes nothing.
  void credit(const tg_PointsCredit& credit);
  void resend(const tg_PointsResend& request);

  // The next item to send: one asked for again first, then the next new one with credit. False: nothing may
  // go.
  bool next_to_send(uint32_t* item);
  size_t encode(uint32_t item, uint8_t* wire) const;  // the whole frame, into kFrameWireBytes

  uint32_t next_item() const { return next_; }  // items made so far
  uint32_t sent() const { return sent_; }       // items 0 .. sent - 1 have been sent at least once
  uint32_t acked() const { return acked_; }

  // Since start-up.
  uint32_t most_kept() const { return most_kept_; }
  uint32_t items_resent() const { return items_resent_; }

 private:
  struct Slot {
    uint16_t bytes = 0;
    uint8_t payload[kFramePayloadBytes] = {};
  };
  Slot slots_[kRingItems];
  uint32_t plan_id_ = 0;
  uint32_t next_ = 0, sent_ = 0, acked_ = 0, granted_ = 0;
  uint32_t again_first_ = 0, again_end_ = 0;
  uint32_t most_kept_ = 0, items_resent_ = 0;
};

}  // namespace tetragauge
