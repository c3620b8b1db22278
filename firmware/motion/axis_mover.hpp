// SPDX-License-Identifier: Apache-2.0
// One stepper axis: moves within its soft limits, and homing. Positions are 64-bit counted steps.
//
// Every move ends going up, so that backlash always lies on the same side. Homing: fast down onto the switch,
// then three times down past its edge and slowly up until it opens; the last opening is the reference, the
// spread of the three is kept.
#pragma once

#include "firmware/hal/board.hpp"
#include "firmware/motion/trapezoid.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

inline constexpr uint32_t kHomeLatches = 3;
inline constexpr uint64_t kOverdueStepNs = 10'000'000;

template <Board B>
class AxisMover {
 public:
  AxisMover(B& board, Axis axis, uint32_t home_input) : board_(board), axis_(axis), home_input_(home_input) {}

  void configure(const tg_AxisMotion& motion) { motion_ = motion; }

  bool busy() const { return task_ != Task::kRest; }
  bool going_up() const { return up_; }
  // False when a step is long overdue: the timer has stopped.
  bool on_time() const { return !busy() || board_.now_ns() <= due_ns_ + kOverdueStepNs; }
  int64_t position_steps() const { return position_; }
  uint32_t home_spread_steps() const { return home_spread_; }
  // What went wrong since the last start of a move; none when the move is good.
  tg_FaultCode fault() const { return fault_; }

  // Steps that were computed after their time, since start-up.
  uint32_t steps_late() const { return steps_late_; }

  // Within the soft limits (the caller has checked).
  void move_to(int64_t target) { move_to(target, motion_.speed); }
  // At another speed, and within the axis' whole travel when its position is not known.
  void jog_to(int64_t target) {
    const int64_t low = position_ - travel(), high = position_ + travel();
    move_to(target < low ? low : target > high ? high : target, motion_.homing_speed);
  }

  // Slows down and ends where that takes it (going up, as every move); the position stays known. Homing goes
  // on.
  void stop() {
    board_.mask_interrupts(true);
    if (task_ == Task::kMove || task_ == Task::kMoveBelow) {
      move_.stop_after(done_);
      const int64_t left = done_ < move_.steps() ? move_.steps() - done_ : 0;
      if (task_ == Task::kMoveBelow) target_ = position_ - left + motion_.backlash_steps;
    }
    board_.mask_interrupts(false);
  }

  void home() {
    fault_ = tg_FaultCode_FAULT_NONE;
    latches_ = 0;
    if (at_home()) {
      // Up and off it first: below the switch there may be little room.
      task_ = Task::kLatch;
      start(position_ + travel(), motion_.latch_speed);
    } else {
      task_ = Task::kSeek;
      start(position_ - travel(), motion_.homing_speed);
    }
  }

  // At once, in the middle of a move: the position is not to be trusted after it.
  void halt() {
    task_ = Task::kRest;
    fault_ = tg_FaultCode_FAULT_NONE;
  }

  // One step, at its instant.
  void on_step_timer() {
    if (task_ == Task::kRest) return;
    board_.step(axis_, up_);
    position_ += up_ ? 1 : -1;
    ++done_;
    if (task_ == Task::kSeek && done_ < move_.steps() && at_home()) {
      move_.stop_after(done_);
      task_ = Task::kSeekStopping;
    } else if (task_ == Task::kLatch && !at_home()) {
      latched();
      return;
    }
    if (done_ < move_.steps()) {
      wait_for_next_step();
    } else {
      finished();
    }
  }

 private:
  enum class Task : uint8_t { kRest, kMoveBelow, kMove, kSeek, kSeekStopping, kBackOff, kLatch };

  void move_to(int64_t target, uint32_t speed) {
    fault_ = tg_FaultCode_FAULT_NONE;
    target_ = target;
    target_speed_ = speed;
    if (target == position_) return;
    const int64_t backlash = motion_.backlash_steps;
    if (target < position_ && backlash > 0) {
      task_ = Task::kMoveBelow;
      start(target - backlash, speed);
    } else {
      task_ = Task::kMove;
      start(target, speed);
    }
  }

  bool at_home() const { return (board_.inputs() & home_input_) != 0; }
  int64_t travel() const { return int64_t{motion_.max_steps} - motion_.home_steps + 2 * past_edge(); }
  // Far enough below the edge to be at full latch speed, and backlash taken up, when it opens.
  int64_t past_edge() const { return int64_t{motion_.backlash_steps} + motion_.latch_speed / 10 + 10; }

  void start(int64_t target, uint32_t speed) {
    up_ = target > position_;
    const int64_t distance = up_ ? target - position_ : position_ - target;
    move_.plan(static_cast<uint32_t>(distance), {speed, motion_.acceleration});
    done_ = 0;
    start_ns_ = board_.now_ns();
    if (move_.steps() == 0) {
      finished();
    } else {
      wait_for_next_step();
    }
  }

  void wait_for_next_step() {
    due_ns_ = start_ns_ + move_.step_time_ns(done_ + 1);
    if (board_.now_ns() > due_ns_) ++steps_late_;
    board_.set_step_alarm_ns(axis_, due_ns_);
  }

  void back_off() {
    task_ = Task::kBackOff;
    start(position_ - past_edge(), motion_.latch_speed);
  }

  void finished() {
    switch (task_) {
      case Task::kMoveBelow:
        task_ = Task::kMove;
        start(target_, target_speed_);
        break;
      case Task::kSeek:
        stop(tg_FaultCode_FAULT_HOME_NOT_FOUND);
        break;
      case Task::kSeekStopping:
        back_off();
        break;
      case Task::kBackOff:
        task_ = Task::kLatch;
        start(position_ + travel(), motion_.latch_speed);
        break;
      case Task::kLatch:
        stop(tg_FaultCode_FAULT_HOME_STUCK);
        break;
      case Task::kMove:
      case Task::kRest:
        task_ = Task::kRest;
        break;
    }
  }

  void stop(tg_FaultCode fault) {
    task_ = Task::kRest;
    fault_ = fault;
  }

  // The switch has just opened: this is the first step above home_steps.
  void latched() {
    const int64_t true_position = int64_t{motion_.home_steps} + 1;
    const int64_t shift = true_position - position_;
    position_ = true_position;
    // The first latch sets the position; the later ones show how well it repeats.
    if (latches_ == 0) {
      low_ = high_ = 0;
      sum_ = 0;
    } else {
      sum_ += shift;
      low_ = sum_ < low_ ? sum_ : low_;
      high_ = sum_ > high_ ? sum_ : high_;
    }
    home_spread_ = static_cast<uint32_t>(high_ - low_);
    if (++latches_ < kHomeLatches) {
      back_off();
    } else {
      task_ = Task::kRest;
    }
  }

  B& board_;
  const Axis axis_;
  const uint32_t home_input_;
  tg_AxisMotion motion_ = tg_AxisMotion_init_zero;
  Task task_ = Task::kRest;
  tg_FaultCode fault_ = tg_FaultCode_FAULT_NONE;
  Trapezoid move_;
  bool up_ = true;
  uint32_t done_ = 0;
  uint64_t start_ns_ = 0, due_ns_ = 0;
  int64_t position_ = 0;
  int64_t target_ = 0;
  uint32_t target_speed_ = 0;
  uint32_t steps_late_ = 0;
  uint32_t latches_ = 0;
  int64_t sum_ = 0, low_ = 0, high_ = 0;
  uint32_t home_spread_ = 0;
};

}  // namespace tetragauge
