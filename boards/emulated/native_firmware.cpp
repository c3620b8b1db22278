// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/native_firmware.hpp"

namespace tetragauge {

Status NativeFirmware::start() {
  controller_ = std::make_unique<Controller<EmulatedBoard>>(board_);
  controller_->begin();
  return Done{};
}

Status NativeFirmware::run(EmulatedBoard::Event event) {
  switch (event) {
    case EmulatedBoard::Event::table_step:
      controller_->on_step_timer(Axis::kTable);
      break;
    case EmulatedBoard::Event::slide_step:
      controller_->on_step_timer(Axis::kSlide);
      break;
    case EmulatedBoard::Event::interlock:
      controller_->on_interlock();
      break;
    case EmulatedBoard::Event::alarm:
      controller_->on_alarm();
      break;
    case EmulatedBoard::Event::samples:
      controller_->on_samples();
      break;
    case EmulatedBoard::Event::none:
      break;
  }
  controller_->poll();
  return Done{};
}

Status NativeFirmware::take_bytes() {
  controller_->poll();
  return Done{};
}

Trace::Seen NativeFirmware::seen() const {
  return {controller_->state(), controller_->fault(), controller_->view() + 1};
}

}  // namespace tetragauge
