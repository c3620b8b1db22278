// SPDX-License-Identifier: GPL-3.0-or-later
// The firmware as ARM code behind a serial line: the controller on the board of its unit tests, whose cameras
// see a plate, but with QEMU's UART0 as its line and the computer's time as its clock. For what a line costs:
// the host's commands run on it as on any machine. Measuring is the board's own image's part.
#include "boards/cortex_m4/chip_bus.hpp"
#include "boards/mps2_an386/fifo_link.hpp"
#include "boards/mps2_an386/uart0_line.hpp"
#include "firmware/controller.hpp"
#include "firmware/hal/fake_board.hpp"

namespace tetragauge {
namespace {

class UartBoard : public FakeBoard {
 public:
  static constexpr const char* kName = "mps2_an386";

  void begin() {
    line_.begin();
    Io<ChipBus>::write(timer0::Reload{}, ~0u);
    Io<ChipBus>::write(timer0::Ctrl{}, 1);
  }
  // Asked for at least every 171 s.
  uint64_t clock_ns() {
    const uint32_t ticks = ~0u - Io<ChipBus>::read(timer0::Value{});
    ticks_ += ticks - static_cast<uint32_t>(ticks_);
    return ticks_ * mps2_bus::kTickNs;
  }
  bool received() const { return line_.received(); }
  size_t read(uint8_t* bytes, size_t capacity) { return line_.read(bytes, capacity); }
  size_t write(const uint8_t* bytes, size_t count) { return line_.write(bytes, count); }

 private:
  Uart0Line<ChipBus> line_;
  uint64_t ticks_ = 0;
};
static_assert(Board<UartBoard>);

}  // namespace
}  // namespace tetragauge

int main() {
  static tetragauge::UartBoard board;
  static tetragauge::Controller<tetragauge::UartBoard> firmware(board);
  board.begin();
  firmware.begin();
  for (;;) {
    if (board.received()) firmware.poll();
    run_next(board, firmware, board.clock_ns());
  }
}
