// SPDX-License-Identifier: Apache-2.0
// The whole firmware of the machine on a board:
//
//   MyBoard board;
//   static Controller<MyBoard> controller(board);   // no heap anywhere
//   controller.begin();
//   for (;;) { controller.poll(); sleep until an interrupt or controller.next_poll_ns(); }
//
// Interrupt entry points and their timing contract: hal/board.hpp.
#pragma once

#include "firmware/hal/board.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

template <Board B>
class Controller {
 public:
  explicit Controller(B& board) : board_(board) {}

  void begin();
  void poll();
  // The latest time the next poll() is due; earlier ones do no harm.
  uint64_t next_poll_ns() const;

  void on_alarm();
  void on_samples();
  void on_step_timer(Axis axis);
  void on_interlock();

  tg_State state() const;
  // The host has been asked for something (a stream item or a heartbeat was sent) and no good frame of it has
  // come since: an emulator in virtual time waits here.
  bool host_owes_answer() const;
  // Nothing happens on the machine until the host asks for something.
  bool resting() const;

 private:
  B& board_;
};

}  // namespace tetragauge
