// SPDX-License-Identifier: Apache-2.0
// The last 8 replies, so that a repeated request gets its answer again and is not executed twice. A request
// is known by its id and the CRC of its payload: another host that starts with the same ids is not fooled.
#pragma once

#include <cstdint>

#include "protocol/message.hpp"

namespace tetragauge {

class ReplyCache {
 public:
  static constexpr uint32_t kReplies = 8;

  // The reply's frame, or null.
  const uint8_t* find(uint32_t id, uint32_t request_crc, size_t* bytes) const {
    for (const Entry& entry : entries_) {
      if (entry.bytes != 0 && entry.id == id && entry.request_crc == request_crc) {
        *bytes = entry.bytes;
        return entry.wire;
      }
    }
    return nullptr;
  }

  // Encodes the reply in place of the oldest one.
  const uint8_t* store(uint32_t id, uint32_t request_crc, const tg_MachineMessage& reply, size_t* bytes) {
    Entry& entry = entries_[next_++ % kReplies];
    entry.id = id;
    entry.request_crc = request_crc;
    entry.bytes = encode_message({Channel::kReply, id}, reply, entry.wire);
    *bytes = entry.bytes;
    return entry.wire;
  }

  void forget() {
    for (Entry& entry : entries_) entry.bytes = 0;
  }

 private:
  struct Entry {
    uint32_t id = 0, request_crc = 0;
    size_t bytes = 0;
    uint8_t wire[kFrameWireBytes] = {};
  };
  Entry entries_[kReplies];
  uint32_t next_ = 0;
};

}  // namespace tetragauge
