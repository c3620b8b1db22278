// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/stream_ring.hpp"

namespace tetragauge {

void StreamRing::start(uint32_t plan_id) {
  plan_id_ = plan_id;
  next_ = sent_ = acked_ = granted_ = 0;
  again_first_ = again_end_ = 0;
}

bool StreamRing::push(const tg_MachineMessage& item) {
  Slot& slot = slots_[next_ % kRingItems];
  slot.bytes = static_cast<uint16_t>(encode_payload(item, slot.payload));
  if (slot.bytes == 0) return false;
  ++next_;
  if (next_ - acked_ > most_kept_) most_kept_ = next_ - acked_;
  return true;
}

void StreamRing::credit(const tg_PointsCredit& credit) {
  if (credit.plan_id != plan_id_) return;
  // Numbers only grow: a late frame with older ones changes nothing.
  if (credit.acked > acked_ && credit.acked <= sent_) acked_ = credit.acked;
  if (credit.granted > granted_) granted_ = credit.granted;
}

void StreamRing::resend(const tg_PointsResend& request) {
  if (request.plan_id != plan_id_ || request.first >= sent_ || request.count == 0) return;
  again_first_ = request.first;
  again_end_ = request.count < sent_ - request.first ? request.first + request.count : sent_;
}

bool StreamRing::next_to_send(uint32_t* item) {
  if (again_first_ < acked_) again_first_ = acked_;
  if (again_first_ < again_end_) {
    *item = again_first_++;
    ++items_resent_;
    return true;
  }
  if (sent_ < next_ && sent_ < granted_) {
    *item = sent_++;
    return true;
  }
  return false;
}

size_t StreamRing::encode(uint32_t item, uint8_t* wire) const {
  const Slot& slot = slots_[item % kRingItems];
  return encode_frame({Channel::kStream, item}, slot.payload, slot.bytes, wire);
}

}  // namespace tetragauge
