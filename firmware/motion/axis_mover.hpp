// SPDX-License-Identifier: Apache-2.0
// One stepper axis: moves within its soft limits, jogs, homing. Positions are 64-bit counted edges.
//
//   axis.move_to(steps);  while (axis.busy()) axis.poll();      // on_step_timer() from the board's interrupt
//
// An edge is scheduled one ahead and made by the timer; the interrupt after it counts it and schedules the
// next, so that an edge's instant does not depend on when the interrupt runs. Moves are planned in poll(),
// never there.
//
// Every move ends going up, so that backlash always lies on the same side. Homing: fast down onto the switch,
// then three times down past its edge and slowly up until it opens; the first opening sets the position, the
// spread of the three is kept.
#pragma once

#include "firmware/hal/board.hpp"
#include "firmware/motion/move_times.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

inline constexpr uint32_t kHomeLatches = 3;
inline constexpr uint32_t kOverdueStepMs = 10;
// Room to plan a stop while steps go on.
inline constexpr uint32_t kStopPlanningMs = 1;

template <Board B>
class AxisMover {
 public:
  AxisMover(B& board, Axis axis, uint32_t home_input) : board_(board), axis_(axis), home_input_(home_input) {}

  void configure(const tg_AxisMotion& motion) { motion_ = motion; }

  bool busy() const { return task_ != Task::kRest; }
  bool going_up() const { return up_; }
  // False when a step is long overdue: the timer has stopped.
  bool on_time() const { return !moving_ || board_.step_clock() <= due_ + kOverdueTicks; }
  int64_t position_steps() const { return position_; }  // not while interrupts may come
  uint32_t home_spread_steps() const { return home_spread_; }
  // What went wrong since the last start of a move; none when the move is good.
  tg_FaultCode fault() const { return fault_; }
  // Steps that were computed after their time, since start-up.
  uint32_t steps_late() const { return steps_late_; }

  // False, and nothing happens, when the target is beyond the soft limits.
  bool move_to(int64_t target) {
    if (target < motion_.min_steps || target > motion_.max_steps) return false;
    go(target, motion_.speed);
    return true;
  }

  // At homing speed, and within the axis' whole travel from here: for a position that is not known.
  void jog_to(int64_t target) {
    const int64_t low = position_ - travel(), high = position_ + travel();
    go(target < low ? low : target > high ? high : target, motion_.homing_speed);
  }

  // Slows down and ends where that takes it (going up, as every move); the position stays known. Homing goes
  // on, and so does the short way up at the end of a move.
  void stop() {
    if (task_ != Task::kMoveBelow && task_ != Task::kMove) return;
    stopping_ = true;
    stop_wanted_ = moving_;
  }

  void home() {
    fault_ = tg_FaultCode_FAULT_NONE;
    latches_ = 0;
    stopping_ = false;
    stop_wanted_ = false;
    seen_home_ = false;
    if (at_home()) {
      latch();  // up and off it first: below the switch there may be little room
    } else {
      task_ = Task::kSeek;
      start(position_ - travel(), motion_.homing_speed);
    }
  }

  // At once, in the middle of a move. The count stays right; a motor stopped at speed may have lost steps.
  void halt() {
    board_.mask_interrupts(true);
    if (moving_ && board_.cancel_step(axis_)) pending_ = false;
    moving_ = false;
    task_ = Task::kRest;
    fault_ = tg_FaultCode_FAULT_NONE;
    board_.mask_interrupts(false);
  }

  // An edge has come.
  void on_step_timer() {
    if (!pending_) return;
    pending_ = false;
    position_ = position_ + (up_ ? 1 : -1);
    if (!moving_) return;  // halted when the edge was out already
    if (task_ == Task::kSeek) {
      if (!seen_home_ && at_home()) {
        seen_home_ = true;
        stop_wanted_ = true;
        home_seen_at_ = position_;
      }
    } else if (task_ == Task::kLatch && !at_home()) {
      opened_ = true;
      moving_ = false;
      return;
    }
    if (move_.given() < move_.steps()) {
      schedule_next();
    } else {
      moving_ = false;
    }
  }

  // After every interrupt: stops under way, and the next leg of a move.
  void poll() {
    if (moving_) {
      if (stop_wanted_) plan_stop();
    } else if (task_ != Task::kRest) {
      leg_done();
    }
  }

 private:
  // kMoveUp: the way up at the end of a move that went below its target.
  enum class Task : uint8_t { kRest, kMoveBelow, kMoveUp, kMove, kSeek, kBackOff, kLatch };
  static constexpr uint64_t kOverdueTicks = uint64_t{B::kStepTicksPerSecond} / 1000 * kOverdueStepMs;

  bool at_home() const { return (board_.inputs() & home_input_) != 0; }
  int64_t travel() const { return int64_t{motion_.max_steps} - motion_.home_steps + 2 * past_edge(); }
  // Far enough below the edge to be at full latch speed, and backlash taken up, when it opens.
  int64_t past_edge() const { return int64_t{motion_.backlash_steps} + motion_.latch_speed / 10 + 10; }

  void go(int64_t target, uint32_t speed) {
    fault_ = tg_FaultCode_FAULT_NONE;
    stopping_ = false;
    stop_wanted_ = false;
    from_ = position_;
    target_ = target;
    speed_ = speed;
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

  // Nothing is scheduled when this is called.
  void start(int64_t target, uint32_t speed) {
    up_ = target > position_;
    const int64_t distance = up_ ? target - position_ : position_ - target;
    if (distance == 0) return;  // poll() goes on
    limits_ = {speed, motion_.acceleration, motion_.jerk};
    move_.plan(static_cast<uint32_t>(distance), limits_, B::kStepTicksPerSecond);
    const uint64_t first = move_.next();
    start_ = board_.step_clock();
    moving_ = true;
    schedule(start_ + first);
  }

  void schedule_next() { schedule(start_ + move_.next()); }

  void schedule(uint64_t due) {
    due_ = due;
    pending_ = true;
    if (!board_.schedule_step(axis_, due, up_ ? 1 : -1)) steps_late_ = steps_late_ + 1;
  }

  // On a copy that is put in place if the steps have not overtaken it; otherwise poll() tries again.
  void plan_stop() {
    board_.mask_interrupts(true);
    MoveTimes stopped = move_;
    board_.mask_interrupts(false);
    const uint32_t at = stopped.given() + limits_.speed * kStopPlanningMs / 1000 + 2;
    stopped.stop_after(at);
    board_.mask_interrupts(true);
    if (move_.given() <= at) {
      stopped.catch_up_with(move_);
      move_ = stopped;
      stop_wanted_ = false;
    }
    board_.mask_interrupts(false);
  }

  void leg_done() {
    switch (task_) {
      case Task::kMoveBelow:
        // Stopped: as far up as takes up the backlash, or to where the move began, which was reached going
        // up.
        if (stopping_) {
          const int64_t up = position_ + motion_.backlash_steps;
          target_ = up < from_ ? up : from_;
        }
        task_ = Task::kMoveUp;
        start(target_, speed_);
        break;
      case Task::kSeek:
        if (!seen_home_) {
          give_up(tg_FaultCode_FAULT_HOME_NOT_FOUND);
        } else if (position_ > home_seen_at_ - past_edge()) {
          back_off(home_seen_at_ - past_edge());
        } else {
          latch();
        }
        break;
      case Task::kBackOff:
        latch();
        break;
      case Task::kLatch:
        if (opened_) {
          latched();
        } else {
          give_up(tg_FaultCode_FAULT_HOME_STUCK);
        }
        break;
      case Task::kMoveUp:
      case Task::kMove:
      case Task::kRest:
        task_ = Task::kRest;
        break;
    }
  }

  void back_off(int64_t target) {
    task_ = Task::kBackOff;
    start(target, motion_.latch_speed);
  }

  void latch() {
    task_ = Task::kLatch;
    opened_ = false;
    start(position_ + travel(), motion_.latch_speed);
  }

  void give_up(tg_FaultCode fault) {
    task_ = Task::kRest;
    fault_ = fault;
  }

  // The switch has opened: this is the first step above home_steps.
  void latched() {
    const int64_t true_position = int64_t{motion_.home_steps} + 1;
    const int64_t shift = true_position - position_;
    position_ = true_position;
    // The first latch sets the position; the later ones show how well it repeats.
    if (latches_ == 0) {
      low_ = high_ = sum_ = 0;
    } else {
      sum_ += shift;
      low_ = sum_ < low_ ? sum_ : low_;
      high_ = sum_ > high_ ? sum_ : high_;
    }
    home_spread_ = static_cast<uint32_t>(high_ - low_);
    if (++latches_ < kHomeLatches) {
      back_off(position_ - past_edge());
    } else {
      task_ = Task::kRest;
    }
  }

  B& board_;
  const Axis axis_;
  const uint32_t home_input_;
  tg_AxisMotion motion_ = tg_AxisMotion_init_zero;

  // Shared with the interrupt.
  volatile Task task_ = Task::kRest;
  volatile bool moving_ = false;   // a leg is under way
  volatile bool pending_ = false;  // an edge is scheduled, or out and not counted
  volatile bool stop_wanted_ = false, seen_home_ = false, opened_ = false;
  volatile int64_t position_ = 0;
  volatile uint32_t steps_late_ = 0;
  MoveTimes move_;
  bool up_ = true;
  uint64_t start_ = 0, due_ = 0;  // ticks of the step clock
  int64_t home_seen_at_ = 0;

  tg_FaultCode fault_ = tg_FaultCode_FAULT_NONE;
  AxisLimits limits_;
  bool stopping_ = false;
  uint32_t speed_ = 0;
  int64_t from_ = 0, target_ = 0;
  uint32_t latches_ = 0;
  int64_t sum_ = 0, low_ = 0, high_ = 0;
  uint32_t home_spread_ = 0;
};

}  // namespace tetragauge
