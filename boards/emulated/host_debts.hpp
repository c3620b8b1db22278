// SPDX-License-Identifier: Apache-2.0
// What the host owes the machine, seen from the line between them: an emulator in virtual time waits for it,
// so that the host's words are stamped at an instant that does not depend on how fast it runs.
//
// A host owes an answer to what has REACHED it: an acknowledgement of a heartbeat, of a stream item that is
// the next one, and a request for the items before one that is not. It has paid as soon as it has spoken,
// whatever the line then does to its words. So a lost frame costs no waiting: time goes on until the next
// one tells the host what it has missed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/message.hpp"

namespace tetragauge {

class HostDebts {
 public:
  // Bytes as the host sent them.
  void host_said(std::span<const uint8_t> bytes);
  // A byte that came out at the host's end, and the place where a frame of the machine ended there.
  void reached_host(uint8_t byte);
  void frame_ended();

  bool owed() const { return owes_for_certain() || asks_again_due_; }
  // Without these the debt is a guess: a host may know of a gap already.
  bool owes_for_certain() const { return heartbeat_ != answered_ || (streaming_ && acked_ < host_next_); }
  // A heartbeat has told the host of items it lacks: it asks for them, at the latest when it finds the line
  // quiet. Only a machine that rests need wait for that.
  bool knows_of_gap() const { return knows_of_gap_; }
  void forgive_guesses() { asks_again_due_ = knows_of_gap_ = false; }
  // Something was lost that only the machine's next heartbeat can tell the host.
  bool news_lost() const { return news_lost_; }

  void another_host() { *this = HostDebts(); }

 private:
  void take_from_host(const Frame& frame);
  void take_event(const tg_HostMessage& message);

  FrameReader from_host_, to_host_;
  tg_HostMessage said_ = tg_HostMessage_init_zero;
  tg_MachineMessage told_ = tg_MachineMessage_init_zero;
  uint32_t heartbeat_ = 0, answered_ = 0;
  bool streaming_ = false;              // the host has granted credit for a scan
  uint32_t host_next_ = 0, acked_ = 0;  // stream items: those it has in order, those it said it has
  bool asked_ = false;                  // for the items before a gap, which have not come yet
  bool asks_again_due_ = false, knows_of_gap_ = false;
  bool arrived_whole_ = false, news_lost_ = false;
};

}  // namespace tetragauge
