// SPDX-License-Identifier: Apache-2.0
// The firmware of an emulated board, wherever its code runs: compiled into this program
// (native_firmware.hpp), or as an image for a chip in another emulator (boards/mps2_an386). It acts on the
// pins of an EmulatedBoard, and what it does takes no virtual time.
#pragma once

#include "boards/emulated/emulated_board.hpp"
#include "host/base/result.hpp"

namespace tetragauge {

class BoardFirmware {
 public:
  virtual ~BoardFirmware() = default;

  // Errors of all three: the code cannot be run any more.
  // From reset: at first, and after a restart of the board.
  virtual Status start() = 0;
  // The interrupt of that event, none for Event::none; then the main loop once.
  virtual Status run(EmulatedBoard::Event event) = 0;
  // The main loop, because bytes of the host have come.
  virtual Status take_bytes() = 0;

  // As the last run left it; see controller.hpp.
  virtual uint64_t next_poll_ns() const = 0;
  virtual bool resting() const = 0;
  virtual Trace::Seen seen() const = 0;
};

}  // namespace tetragauge
