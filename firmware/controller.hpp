// SPDX-License-Identifier: Apache-2.0
// The whole firmware of the machine on a board:
//
//   MyBoard board;
//   static Controller<MyBoard> controller(board);   // no heap anywhere
//   controller.begin();
//   for (;;) { controller.poll(); sleep until an interrupt or controller.next_poll_ns(); }
//
// Interrupt entry points and their timing contract: hal/board.hpp.
#pragma once

#include "firmware/answer_request.hpp"
#include "firmware/machine.hpp"

namespace tetragauge {

// A reply that the line does not take for so long does not hold up a restart.
inline constexpr uint64_t kRestartAfterNs = 1'000'000'000;

template <Board B>
class Controller {
 public:
  explicit Controller(B& board) : m_(board), requests_(m_) {}
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  void begin() {
    m_.supervisor.laser_off();
    m_.board.set_mirrors(0, 0);
    m_.store.find();
    m_.use_stored_calibration();
    if (m_.board.reset_cause() == tg_ResetCause_RESET_WATCHDOG) {
      m_.link.log(tg_LogLevel_LOG_ERROR, "the watchdog has restarted the firmware");
    }
    const tg_FaultCode fault = m_.supervisor.input_fault();
    if (fault == tg_FaultCode_FAULT_NONE) {
      m_.supervisor.enter(tg_State_STATE_IDLE);
    } else {
      m_.fail(fault);
    }
  }

  void poll() {
    if (gone_) return;
    const uint64_t start_ns = m_.board.now_ns();
    while (!leaving() && m_.link.receive()) {
      handle(m_.link.frame());
      m_.link.send();  // its reply must be out before the next frame is read
    }
    check_inputs();
    check_silence();
    m_.table.poll();
    m_.slide.poll();
    check_motion();
    run_scan();
    run_service();
    if (m_.link.heartbeat_due()) m_.link.heartbeat(report_heartbeat(m_));
    m_.link.send();
    // All check in: this loop, both axes, and the converter (which is a fault of its own). Without, the chip
    // restarts.
    if (m_.table.on_time() && m_.slide.on_time()) m_.board.kick_watchdog();
    const auto took_us = static_cast<uint32_t>((m_.board.now_ns() - start_ns) / 1000);
    if (took_us > m_.longest_poll_us) m_.longest_poll_us = took_us;
    leave_if_asked();
  }

  // The latest time the next poll() is due; earlier ones do no harm.
  uint64_t next_poll_ns() const {
    if (gone_) return ~uint64_t{0};
    uint64_t next = m_.link.next_heartbeat_ns();
    const auto not_later_than = [&next](uint64_t time_ns) { next = time_ns < next ? time_ns : next; };
    not_later_than(m_.scan.next_poll_ns());
    not_later_than(m_.self_test.next_poll_ns());
    if (state() == tg_State_STATE_SCANNING) not_later_than(m_.supervisor.silence_ns());
    // A line that took only part of a frame, or a store at work, is asked again after a while.
    if (m_.link.sending() || m_.store.busy() || leaving()) not_later_than(m_.board.now_ns() + 100'000);
    return next;
  }

  void on_alarm() { m_.scan.on_alarm(); }
  void on_samples() {
    if (m_.self_test.sampling()) {
      m_.self_test.on_samples();
    } else {
      m_.scan.on_samples();
    }
  }
  void on_step_timer(Axis axis) {
    m_.self_test.on_step_timer(axis);
    (axis == Axis::kTable ? m_.table : m_.slide).on_step_timer();
  }
  // The laser goes off here; the state follows in poll().
  void on_interlock() {
    if (m_.supervisor.input_fault() == tg_FaultCode_FAULT_INTERLOCK) m_.supervisor.laser_off();
  }

  // A line for the host; `text` is a literal.
  void log(tg_LogLevel level, const char* text) { m_.link.log(level, text); }

  tg_State state() const { return m_.state(); }
  tg_FaultCode fault() const { return m_.supervisor.fault(); }
  uint32_t view() const { return m_.scan.view(); }
  // Nothing happens on the machine until the host asks for something.
  bool resting() const {
    return state() != tg_State_STATE_HOMING && state() != tg_State_STATE_SCANNING && !m_.moving() &&
           !(m_.scan.active() && state() != tg_State_STATE_PAUSED) && !m_.link.sending() &&
           !m_.self_test.running() && !m_.store.busy() && !leaving();
  }

 private:
  bool leaving() const { return m_.leaving != Machine<B>::Leaving::kNo; }

  // ---------------------------------------------------------------- what may go wrong

  void check_inputs() {
    const tg_FaultCode fault = m_.supervisor.input_fault();
    const bool latched = state() == tg_State_STATE_FAULT || state() == tg_State_STATE_ESTOP;
    if (fault == tg_FaultCode_FAULT_INTERLOCK && state() != tg_State_STATE_ESTOP)
      m_.fail(fault);
    else if (fault != tg_FaultCode_FAULT_NONE && !latched)
      m_.fail(fault);
    // Moving away from an end switch is how one gets off it.
    const uint32_t ahead = m_.slide.going_up() ? Inputs::kSlideLimitHigh : Inputs::kSlideLimitLow;
    if (m_.slide.busy() && (m_.board.inputs() & ahead)) m_.fail(tg_FaultCode_FAULT_LIMIT);
  }

  void check_silence() {
    if (state() != tg_State_STATE_SCANNING || !m_.supervisor.host_silent()) return;
    m_.pause();
    ++m_.silences;
    m_.link.log(tg_LogLevel_LOG_WARNING, "the host was silent: paused");
  }

  void check_motion() {
    const AxisMover<B>* const axes[] = {&m_.table, &m_.slide};
    for (const AxisMover<B>* axis : axes) {
      if (axis->fault() != tg_FaultCode_FAULT_NONE && state() == tg_State_STATE_HOMING)
        m_.fail(axis->fault());
    }
    if (state() == tg_State_STATE_HOMING && !m_.moving()) {
      m_.homed = true;
      m_.supervisor.enter(tg_State_STATE_READY);
    }
  }

  // ---------------------------------------------------------------- what goes on

  void run_scan() {
    const bool was_active = m_.scan.active();
    const tg_FaultCode found = m_.scan.poll();
    if (found != tg_FaultCode_FAULT_NONE) m_.fail(found);
    if (!was_active || m_.scan.active()) return;
    m_.plan.forget();
    if (state() == tg_State_STATE_SCANNING || state() == tg_State_STATE_PAUSED) {
      m_.supervisor.enter(tg_State_STATE_READY);
    }
  }

  void run_service() {
    m_.self_test.poll(!m_.scan.sampling());
    m_.store.step();
    if (m_.link.can_reply() && requests_.finish(&m_.outgoing)) m_.link.reply_to_pending(m_.outgoing);
  }

  void leave_if_asked() {
    if (!leaving()) return;
    if (leave_by_ns_ == 0) leave_by_ns_ = m_.board.now_ns() + kRestartAfterNs;
    if (m_.link.sending() && m_.board.now_ns() < leave_by_ns_) return;
    m_.supervisor.laser_off();
    gone_ = true;
    m_.board.restart(m_.leaving == Machine<B>::Leaving::kBootloader);
  }

  // ---------------------------------------------------------------- what the host says

  void handle(const Frame& frame) {
    if (frame.header.channel != Channel::kRequest && frame.header.channel != Channel::kEvent) return;
    m_.supervisor.host_heard();
    const bool good = decode_message(frame, &message_);
    if (frame.header.channel == Channel::kEvent) {
      if (good) handle_event();
      return;
    }
    if (m_.link.replied_before(frame)) return;
    tg_MachineMessage& reply = m_.outgoing;
    reply = tg_MachineMessage_init_zero;
    if (!good) {
      requests_.refuse(&reply, tg_RefuseReason_REFUSE_MALFORMED,
                       "does not decode; host and firmware may differ in version");
      m_.link.reply(frame, reply);
    } else if (requests_.answer(message_, &reply)) {
      m_.link.reply(frame, reply);
    } else {
      m_.link.answer_later(frame);
    }
  }

  void handle_event() {
    switch (message_.which_body) {
      case tg_HostMessage_points_credit_tag:
        m_.ring.credit(message_.body.points_credit);
        break;
      case tg_HostMessage_points_resend_tag:
        m_.ring.resend(message_.body.points_resend);
        break;
      default:  // HeartbeatAck: that it came is all it says
        break;
    }
  }

  Machine<B> m_;
  RequestAnswerer<B> requests_;
  bool gone_ = false;
  uint64_t leave_by_ns_ = 0;
  tg_HostMessage message_ = tg_HostMessage_init_zero;
};

}  // namespace tetragauge
