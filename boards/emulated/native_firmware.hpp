// SPDX-License-Identifier: Apache-2.0
// The firmware as a part of this program.
#pragma once

#include <memory>

#include "boards/emulated/board_firmware.hpp"
#include "firmware/controller.hpp"

namespace tetragauge {

class NativeFirmware : public BoardFirmware {
 public:
  explicit NativeFirmware(EmulatedBoard& board) : board_(board) {}

  Status start() override;
  Status run(EmulatedBoard::Event event) override;
  Status take_bytes() override;
  uint64_t next_poll_ns() const override { return controller_->next_poll_ns(); }
  bool resting() const override { return controller_->resting(); }
  Trace::Seen seen() const override;

 private:
  EmulatedBoard& board_;
  std::unique_ptr<Controller<EmulatedBoard>> controller_;
};

}  // namespace tetragauge
