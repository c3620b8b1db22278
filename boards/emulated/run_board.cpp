// SPDX-License-Identifier: Apache-2.0
#include "boards/emulated/run_board.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

namespace tetragauge {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// How long one wait may keep `stop` from being seen.
constexpr int kWaitSlice_ms = 50;

// A host may know already of the gap that an item or a heartbeat shows it. One that does not asks at once, or
// when it finds the line quiet; longer than this it is not waited for.
constexpr milliseconds kGuessedDebt{400};

// Holds virtual time against wall time.
class Pace {
 public:
  explicit Pace(double speed) : speed_(speed) {}
  // Virtual time that wall time allows by now.
  uint64_t allowed_ns() const {
    const std::chrono::duration<double, std::nano> wall = Clock::now() - start_;
    return start_ns_ + static_cast<uint64_t>(wall.count() * speed_);
  }
  void restart(uint64_t virtual_ns) {
    start_ = Clock::now();
    start_ns_ = virtual_ns;
  }
  milliseconds wait_for(uint64_t virtual_ns) const {
    const uint64_t allowed = allowed_ns();
    if (virtual_ns <= allowed) return milliseconds(0);
    const double wall_ms = static_cast<double>(virtual_ns - allowed) * 1e-6 / speed_;
    return milliseconds(static_cast<int>(std::min(wall_ms, double{kWaitSlice_ms})) + 1);
  }

 private:
  double speed_;
  Clock::time_point start_ = Clock::now();
  uint64_t start_ns_ = 0;
};

void trace(const EmulatedBoard& board, const BoardFirmware& firmware) {
  if (board.trace() == nullptr) return;
  Trace::Seen seen = firmware.seen();
  if (seen.state != tg_State_STATE_SCANNING && seen.state != tg_State_STATE_PAUSED) seen.view = 0;
  board.trace()->machine(board.now_ns(), seen);
}

}  // namespace

Status run_board(EmulatedBoard& board, BoardFirmware& firmware, HostLine& line, const std::atomic<bool>& stop,
                 const PaceOptions& options) {
  if (const Status started = firmware.start(); !started) return started;
  trace(board, firmware);
  Pace pace(options.speed.value_or(1.0)), silent_pace(1.0);
  bool silent = false;
  auto waiting_since = Clock::now();
  bool was_waiting = false;

  while (!stop && !line.closed()) {
    switch (board.take_restart()) {
      case EmulatedBoard::Restart::no:
        break;
      case EmulatedBoard::Restart::firmware:
        if (const Status started = firmware.start(); !started) return started;
        trace(board, firmware);
        break;
      case EmulatedBoard::Restart::bootloader:
        return Done{};  // gone until somebody starts it again
    }
    // A machine that rests lets time stand still, unless the line is at work, or has lost what the host can
    // learn from the next heartbeat alone.
    EmulatedBoard::Due due = board.next_event();
    const uint64_t line_ns = line.next_event_ns(board.now_ns());
    const uint64_t poll_ns = std::max(firmware.next_poll_ns(), board.now_ns());
    const uint64_t next_ns = std::min({due.time_ns, poll_ns, line_ns});
    const bool resting = next_ns == EmulatedBoard::kNever ||
                         (firmware.resting() && line_ns == EmulatedBoard::kNever && !line.host_lacks_news());
    const bool waiting =
        resting || line.host_owes_answer() || (firmware.resting() && line.host_knows_of_gap());
    if (!waiting) silent = false;
    if (waiting && !was_waiting) waiting_since = Clock::now();
    was_waiting = waiting;

    if (waiting && !silent) {
      if (line.wait_for_bytes(kWaitSlice_ms, board.now_ns())) {
        if (const Status run = firmware.take_bytes(); !run) return run;
        trace(board, firmware);
        was_waiting = false;  // the next wait, if any, is a new one
        pace.restart(board.now_ns());
        continue;
      }
      const auto waited = Clock::now() - waiting_since;
      if (!line.host_owes_for_certain() && waited >= kGuessedDebt) line.forgive_guesses();
      if (!resting && waited >= milliseconds(options.silence_after_ms)) {
        silent = true;
        silent_pace.restart(board.now_ns());
      }
      continue;
    }

    if (silent || options.speed) {
      const Pace& held_by = silent ? silent_pace : pace;
      if (const milliseconds wait = held_by.wait_for(next_ns); wait.count() > 0) {
        if (!silent) {
          std::this_thread::sleep_for(wait);
        } else if (line.wait_for_bytes(static_cast<int>(wait.count()), board.now_ns())) {
          silent = false;
          if (const Status run = firmware.take_bytes(); !run) return run;
          trace(board, firmware);
        }
        continue;
      }
    }
    if (due.time_ns == next_ns) {
      board.take(due);
    } else {
      board.advance_to(next_ns);
      due.event = EmulatedBoard::Event::none;
    }
    line.deliver(board.now_ns());
    if (const Status run = firmware.run(due.event); !run) return run;
    trace(board, firmware);
  }
  return Done{};
}

}  // namespace tetragauge
