// SPDX-License-Identifier: Apache-2.0
// State, latched fault and laser in one place: nothing else writes the laser pin.
#pragma once

#include "firmware/hal/board.hpp"
#include "firmware/safety/state_table.hpp"

namespace tetragauge {

inline constexpr uint64_t kHostSilenceNs = 400'000'000;  // then PAUSED
inline constexpr uint32_t kNeededInputs =
    Inputs::kInterlockClosed | Inputs::kMirrorsGood | Inputs::kLaserGood;

template <Board B>
class Supervisor {
 public:
  explicit Supervisor(B& board) : board_(board) {}

  tg_State state() const { return state_; }
  tg_FaultCode fault() const { return fault_; }
  uint64_t fault_clock_us() const { return fault_clock_us_; }

  void host_heard() { host_heard_ns_ = board_.now_ns(); }
  uint64_t silence_ns() const { return host_heard_ns_ + kHostSilenceNs; }
  bool host_silent() const { return board_.now_ns() >= silence_ns(); }

  // Only along the table. The state first, then the laser: an interrupt between the two cannot turn it on any
  // more.
  void enter(tg_State to) {
    if (transition_allowed(state_, to)) state_ = to;
    if (state_ != tg_State_STATE_SCANNING) laser_off();
  }

  // Latches the first fault; an open interlock is ESTOP and goes over any other. True when this one is new.
  bool latch(tg_FaultCode code) {
    laser_off();
    const bool interlock = code == tg_FaultCode_FAULT_INTERLOCK;
    if (state_ == tg_State_STATE_ESTOP || (state_ == tg_State_STATE_FAULT && !interlock)) return false;
    fault_ = code;
    fault_clock_us_ = board_.now_ns() / 1000;
    enter(interlock ? tg_State_STATE_ESTOP : tg_State_STATE_FAULT);
    return true;
  }

  // What the inputs complain about now.
  tg_FaultCode input_fault() const {
    const uint32_t inputs = board_.inputs();
    if (!(inputs & Inputs::kInterlockClosed)) return tg_FaultCode_FAULT_INTERLOCK;
    if (!(inputs & Inputs::kMirrorsGood)) return tg_FaultCode_FAULT_MIRROR;
    if (!(inputs & Inputs::kLaserGood)) return tg_FaultCode_FAULT_LASER;
    return tg_FaultCode_FAULT_NONE;
  }

  // False when the cause is still there.
  bool clear(tg_State to) {
    if (input_fault() != tg_FaultCode_FAULT_NONE) return false;
    fault_ = tg_FaultCode_FAULT_NONE;
    enter(to);
    return true;
  }

  // On only in SCANNING, with a host that listens and every input good.
  bool laser_on() {
    if (!laser_allowed()) {
      laser_off();
      return false;
    }
    board_.set_laser(true);
    // Looked at again: an interlock that opened in between has turned the laser off before this turned it on.
    if (laser_allowed()) return true;
    laser_off();
    return false;
  }
  void laser_off() { board_.set_laser(false); }

 private:
  bool laser_allowed() const {
    return state_ == tg_State_STATE_SCANNING && !host_silent() &&
           (board_.inputs() & kNeededInputs) == kNeededInputs;
  }

  B& board_;
  volatile tg_State state_ = tg_State_STATE_BOOT;
  tg_FaultCode fault_ = tg_FaultCode_FAULT_NONE;
  uint64_t fault_clock_us_ = 0;
  uint64_t host_heard_ns_ = 0;
};

}  // namespace tetragauge
