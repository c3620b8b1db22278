// SPDX-License-Identifier: Apache-2.0
// What each interrupt does to board and controller: the image's handlers, and a test's model of the chip,
// call these.
#pragma once

#include "firmware/hal/board.hpp"

namespace tetragauge {

template <class B, class Firmware>
struct Interrupts {
  static void tick(B& board) { board.on_tick(); }
  static void line(B& board) { board.line().on_usart_interrupt(); }
  static void line_out(B& board) { board.line().on_dma_interrupt(); }
  static void step(B& board, Firmware& firmware) {
    board.steps().on_interrupt([&firmware](Axis axis) { firmware.on_step_timer(axis); });
  }
  static void interlock(B& board, Firmware& firmware) {
    board.input_pins().on_interrupt();
    firmware.on_interlock();
  }
  static void alarm(B& board, Firmware& firmware) {
    if (board.clock().on_interrupt()) firmware.on_alarm();
  }
  static void samples(B& board, Firmware& firmware) {
    if (board.on_samples_dma()) firmware.on_samples();
  }
};

}  // namespace tetragauge
