// SPDX-License-Identifier: Apache-2.0
// What the host owes: an answer to the last heartbeat, and an acknowledgement of the last stream item sent.
// An emulator in virtual time waits for it. A host that repeats itself has lost what was sent to it and owes
// nothing until more is sent; time then goes on, and the next heartbeat tells it what it missed.
#pragma once

#include <cstdint>

namespace tetragauge {

class Obligations {
 public:
  void heartbeat_sent(uint32_t counter) {
    heartbeat_ = counter;
    excused_ = false;
  }
  void item_sent(uint32_t items_sent) {
    sent_ = items_sent;
    excused_ = false;
  }
  void stream_started() { sent_ = acked_ = 0; }

  void heartbeat_answered(uint32_t counter) {
    if (counter == answered_) excused_ = true;
    answered_ = counter;
  }
  void credit_came(uint32_t acked) {
    if (acked == acked_) excused_ = true;
    acked_ = acked;
  }

  bool owed() const { return !excused_ && (heartbeat_ != answered_ || acked_ < sent_); }

 private:
  uint32_t heartbeat_ = 0, answered_ = 0;
  uint32_t sent_ = 0, acked_ = 0;
  bool excused_ = true;
};

}  // namespace tetragauge
