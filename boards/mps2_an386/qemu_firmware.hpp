// SPDX-License-Identifier: Apache-2.0
// The firmware as an image for a Cortex-M4F, run by QEMU: the world's end of the bus. The pins are those of
// the same EmulatedBoard, so that the world behind it, its time and its line to the host are the same.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "boards/emulated/board_firmware.hpp"
#include "boards/mps2_an386/bus.hpp"
#include "boards/mps2_an386/qemu_process.hpp"

namespace tetragauge {

class QemuFirmware : public BoardFirmware {
 public:
  QemuFirmware(EmulatedBoard& board, Storage& store, std::unique_ptr<QemuProcess> qemu)
      : board_(board), store_(store), qemu_(std::move(qemu)) {}

  Status start() override;
  Status run(EmulatedBoard::Event event) override;
  Status take_bytes() override;
  uint64_t next_poll_ns() const override { return last_.next_poll_ns; }
  bool resting() const override { return last_.resting != 0; }
  Trace::Seen seen() const override;

  // What the image's processor has done, by the machine's state before and by what has come.
  struct Work {
    uint64_t turns = 0, ticks = 0;
  };
  using WorkTable =
      std::array<std::array<Work, static_cast<size_t>(mps2_bus::Call::answer)>, _tg_State_ARRAYSIZE>;
  const WorkTable& work() const { return work_; }

 private:
  Status turn(const mps2_bus::WorldSays& says, const void* payload, size_t payload_bytes);
  Status do_actions(size_t count);
  Status answer(const mps2_bus::ImageSays& question);
  Status say(mps2_bus::WorldSays says, const void* payload, size_t payload_bytes);
  std::vector<uint8_t> next_of_line();

  EmulatedBoard& board_;
  Storage& store_;
  std::unique_ptr<QemuProcess> qemu_;
  mps2_bus::ImageSays last_;
  std::array<PsdSample, kBurstSamples> burst_{};
  size_t burst_count_ = 0;
  std::vector<uint8_t> line_;  // of the host, not yet given to the image
  WorkTable work_{};
};

}  // namespace tetragauge
