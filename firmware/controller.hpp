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

#include "firmware/link/host_link.hpp"
#include "firmware/machine_config.hpp"
#include "firmware/motion/axis_mover.hpp"
#include "firmware/safety/supervisor.hpp"
#include "firmware/scan/scan_runner.hpp"
#include "firmware/version.hpp"
#include "protocol/schema_hash.hpp"
#include "protocol/state_name.hpp"

namespace tetragauge {

template <Board B>
class Controller {
 public:
  explicit Controller(B& board)
      : board_(board),
        supervisor_(board),
        table_(board, Axis::kTable, Inputs::kTableHome),
        slide_(board, Axis::kSlide, Inputs::kSlideHome),
        scan_(board, supervisor_, table_, slide_, ring_),
        link_(board, ring_) {}
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  void begin() {
    supervisor_.laser_off();
    board_.set_mirrors(0, 0);
    config_ = nominal_config();
    use_config();
    const tg_FaultCode fault = supervisor_.input_fault();
    if (fault == tg_FaultCode_FAULT_NONE) {
      supervisor_.enter(tg_State_STATE_IDLE);
    } else {
      fail(fault);
    }
  }

  void poll() {
    while (link_.receive()) {
      handle(link_.frame());
      link_.send();  // its reply must be out before the next frame is read
    }
    check_inputs();
    check_silence();
    table_.poll();
    slide_.poll();
    check_motion();
    const bool was_active = scan_.active();
    const tg_FaultCode found = scan_.poll();
    if (found != tg_FaultCode_FAULT_NONE) fail(found);
    if (was_active && !scan_.active()) scan_ended();
    if (link_.heartbeat_due()) link_.heartbeat(heartbeat());
    link_.send();
    // All check in: this loop, both axes, and the converter (which is a fault of its own). Without, the chip
    // restarts.
    if (table_.on_time() && slide_.on_time()) board_.kick_watchdog();
  }

  // The latest time the next poll() is due; earlier ones do no harm.
  uint64_t next_poll_ns() const {
    uint64_t next = link_.next_heartbeat_ns();
    const auto not_later_than = [&next](uint64_t time_ns) { next = time_ns < next ? time_ns : next; };
    not_later_than(scan_.next_poll_ns());
    if (state() == tg_State_STATE_SCANNING) not_later_than(supervisor_.silence_ns());
    // A line that took only part of a frame is asked again after some bytes' time.
    if (link_.sending()) not_later_than(board_.now_ns() + 100'000);
    return next;
  }

  void on_alarm() { scan_.on_alarm(); }
  void on_samples() { scan_.on_samples(); }
  void on_step_timer(Axis axis) { (axis == Axis::kTable ? table_ : slide_).on_step_timer(); }
  // The laser goes off here; the state follows in poll().
  void on_interlock() {
    if (supervisor_.input_fault() == tg_FaultCode_FAULT_INTERLOCK) supervisor_.laser_off();
  }

  tg_State state() const { return supervisor_.state(); }
  // A stream item or a heartbeat has gone out and the host has not answered it yet: an emulator in virtual
  // time waits here (link/obligations.hpp).
  bool host_owes_answer() const { return link_.obligations().owed(); }
  // Nothing happens on the machine until the host asks for something.
  bool resting() const {
    return state() != tg_State_STATE_HOMING && state() != tg_State_STATE_SCANNING && !table_.busy() &&
           !slide_.busy() && !(scan_.active() && state() != tg_State_STATE_PAUSED) && !link_.sending();
  }

 private:
  // ---------------------------------------------------------------- what may go wrong

  void fail(tg_FaultCode code) {
    // A stage stopped in the middle of a move has lost steps.
    if (table_.busy() || slide_.busy()) homed_ = false;
    table_.halt();
    slide_.halt();
    const bool is_new = supervisor_.latch(code);
    scan_.end(code);
    plan_.forget();
    if (!is_new) return;
    tg_Fault event = tg_Fault_init_zero;
    event.code = code;
    event.clock_us = supervisor_.fault_clock_us();
    link_.fault(event);
  }

  void check_inputs() {
    const tg_FaultCode fault = supervisor_.input_fault();
    const bool latched = state() == tg_State_STATE_FAULT || state() == tg_State_STATE_ESTOP;
    if (fault == tg_FaultCode_FAULT_INTERLOCK && state() != tg_State_STATE_ESTOP)
      fail(fault);
    else if (fault != tg_FaultCode_FAULT_NONE && !latched)
      fail(fault);
    // Moving away from an end switch is how one gets off it.
    const uint32_t ahead = slide_.going_up() ? Inputs::kSlideLimitHigh : Inputs::kSlideLimitLow;
    if (slide_.busy() && (board_.inputs() & ahead)) fail(tg_FaultCode_FAULT_LIMIT);
  }

  void check_silence() {
    if (state() == tg_State_STATE_SCANNING && supervisor_.host_silent()) pause();
  }

  void check_motion() {
    const AxisMover<B>* const axes[] = {&table_, &slide_};
    for (const AxisMover<B>* axis : axes) {
      if (axis->fault() != tg_FaultCode_FAULT_NONE && state() == tg_State_STATE_HOMING) fail(axis->fault());
    }
    if (state() == tg_State_STATE_HOMING && !table_.busy() && !slide_.busy()) {
      homed_ = true;
      supervisor_.enter(tg_State_STATE_READY);
    }
  }

  void pause() {
    supervisor_.enter(tg_State_STATE_PAUSED);
    scan_.interrupt_ray();
  }

  void scan_ended() {
    plan_.forget();
    if (state() == tg_State_STATE_SCANNING || state() == tg_State_STATE_PAUSED) {
      supervisor_.enter(tg_State_STATE_READY);
    }
  }

  void use_config() {
    table_.configure(config_.stage.table);
    slide_.configure(config_.stage.slide);
    scan_.configure(config_);
    config_crc_ = config_crc(config_);
  }

  // ---------------------------------------------------------------- what the host says

  void handle(const Frame& frame) {
    if (frame.header.channel != Channel::kRequest && frame.header.channel != Channel::kEvent) return;
    supervisor_.host_heard();
    const bool good = decode_message(frame, &message_);
    if (frame.header.channel == Channel::kEvent) {
      if (good) handle_event();
      return;
    }
    if (link_.replied_before(frame)) return;
    reply_ = tg_MachineMessage_init_zero;
    if (good) {
      handle_request();
    } else {
      refuse(tg_RefuseReason_REFUSE_MALFORMED, "does not decode; host and firmware may differ in version");
    }
    link_.reply(frame, reply_);
  }

  void handle_event() {
    switch (message_.which_body) {
      case tg_HostMessage_heartbeat_ack_tag:
        link_.obligations().heartbeat_answered(message_.body.heartbeat_ack.counter);
        break;
      case tg_HostMessage_points_credit_tag:
        ring_.credit(message_.body.points_credit);
        if (message_.body.points_credit.plan_id == ring_.plan_id()) {
          link_.obligations().credit_came(message_.body.points_credit.acked);
        }
        break;
      case tg_HostMessage_points_resend_tag:
        ring_.resend(message_.body.points_resend);
        break;
      default:
        break;
    }
  }

  void done() { reply_.which_body = tg_MachineMessage_done_tag; }

  void refuse(tg_RefuseReason reason, const char* detail) {
    reply_.which_body = tg_MachineMessage_refused_tag;
    tg_Refused& refused = reply_.body.refused;
    refused.reason = reason;
    refused.state = state();
    copy_text(refused.detail, sizeof refused.detail, detail);
  }

  static void copy_text(char* to, size_t size, const char* from) {
    size_t i = 0;
    for (; i + 1 < size && from[i] != '\0'; ++i) to[i] = from[i];
    to[i] = '\0';
  }

  void handle_request() {
    if (!request_allowed(state(), message_.which_body)) {
      refuse(tg_RefuseReason_REFUSE_STATE, state_name(state()));
      return;
    }
    // After a fault: the end of the broken scan waits for room in the ring, and its rays for their geometry.
    const bool needs_scan_over = message_.which_body == tg_HostMessage_set_config_tag ||
                                 message_.which_body == tg_HostMessage_home_tag;
    if (needs_scan_over && scan_.active()) {
      refuse_undelivered();
      return;
    }
    switch (message_.which_body) {
      case tg_HostMessage_hello_tag:
        hello();
        break;
      case tg_HostMessage_get_status_tag:
        status();
        break;
      case tg_HostMessage_get_config_tag:
        get_config();
        break;
      case tg_HostMessage_set_config_tag:
        set_config();
        break;
      case tg_HostMessage_clear_fault_tag:
        clear_fault();
        break;
      case tg_HostMessage_home_tag:
        home();
        break;
      case tg_HostMessage_scan_load_tag:
        scan_load();
        break;
      case tg_HostMessage_scan_start_tag:
        scan_start();
        break;
      case tg_HostMessage_scan_pause_tag:
        if (state() == tg_State_STATE_SCANNING) pause();
        done();
        break;
      case tg_HostMessage_scan_resume_tag:
        supervisor_.enter(tg_State_STATE_SCANNING);
        done();
        break;
      case tg_HostMessage_scan_abort_tag:
        scan_abort();
        break;
      default:
        refuse(tg_RefuseReason_REFUSE_UNKNOWN, "is an event, or unknown to this firmware");
        break;
    }
  }

  void refuse_undelivered() {
    refuse(tg_RefuseReason_REFUSE_UNDELIVERED,
           "acknowledge the last scan's items, or ScanAbort in READY drops them");
  }

  void hello() {
    link_.forget_replies();
    link_.start_heartbeats();
    reply_.which_body = tg_MachineMessage_hello_reply_tag;
    tg_HelloReply& hello = reply_.body.hello_reply;
    hello.protocol_version = kProtocolVersion;
    hello.schema_hash = kSchemaHash;
    copy_text(hello.firmware_version, sizeof hello.firmware_version, kFirmwareVersion);
    copy_text(hello.board, sizeof hello.board, B::kName);
    hello.capabilities = B::kCapabilities;
    hello.boot_id = board_.boot_id();
    hello.state = state();
    hello.max_views = kMaxViews;
    hello.config_crc = config_crc_;
    hello.sample_period_ns = B::kSamplePeriodNs;
    hello.ring_items = kRingItems;
  }

  void status() {
    reply_.which_body = tg_MachineMessage_status_tag;
    tg_Status& status = reply_.body.status;
    status.state = state();
    status.fault = supervisor_.fault();
    status.fault_clock_us = supervisor_.fault_clock_us();
    status.clock_us = board_.now_ns() / 1000;
    board_.mask_interrupts(true);  // a step in between would tear a 64-bit position
    const int64_t table_at = table_.position_steps(), slide_at = slide_.position_steps();
    board_.mask_interrupts(false);
    status.table_udeg = table_udeg(config_, table_at);
    status.slide_um = slide_um(config_, slide_at);
    status.homed = homed_;
    status.inputs = board_.inputs();
    status.plan_id = plan_.plan_id();
    status.views_loaded = plan_.views_loaded();
    status.view = scan_.view();
    status.ray = scan_.ray();
    status.stream_next = ring_.next_item();
    status.stream_acked = ring_.acked();
    status.bad_frames = link_.bad_frames();
    status.config_crc = config_crc_;
    status.home_spread_table_udeg = static_cast<uint32_t>(table_udeg(config_, table_.home_spread_steps()));
    status.home_spread_slide_um = static_cast<uint32_t>(slide_um(config_, slide_.home_spread_steps()));
  }

  tg_Heartbeat heartbeat() const {
    tg_Heartbeat beat = tg_Heartbeat_init_zero;
    beat.state = state();
    beat.fault = supervisor_.fault();
    beat.clock_us = board_.now_ns() / 1000;
    beat.plan_id = ring_.plan_id();
    beat.stream_next = ring_.sent();
    beat.view = scan_.view();
    beat.views = plan_.views();
    return beat;
  }

  void get_config() {
    tg_Config part = tg_Config_init_zero;
    if (!get_part(config_, message_.body.get_config.part, &part)) {
      refuse(tg_RefuseReason_REFUSE_OUT_OF_RANGE, "no such part of the configuration");
      return;
    }
    reply_.which_body = tg_MachineMessage_config_tag;
    reply_.body.config = part;
  }

  void set_config() {
    const tg_Config& part = message_.body.set_config;
    if (const char* error = config_error(part)) {
      refuse(tg_RefuseReason_REFUSE_OUT_OF_RANGE, error);
      return;
    }
    set_part(&config_, part);
    use_config();
    plan_.forget();
    if (part.which_part == tg_Config_stage_tag) homed_ = false;
    supervisor_.enter(homed_ ? tg_State_STATE_READY : tg_State_STATE_IDLE);
    done();
  }

  void clear_fault() {
    if (state() != tg_State_STATE_FAULT && state() != tg_State_STATE_ESTOP) {
      done();
      return;
    }
    if (supervisor_.clear(homed_ ? tg_State_STATE_READY : tg_State_STATE_IDLE)) {
      done();
    } else {
      refuse(tg_RefuseReason_REFUSE_STILL_FAULTY,
             "the cause is still there: interlock, mirror or laser driver");
    }
  }

  void home() {
    plan_.forget();
    homed_ = false;
    supervisor_.enter(tg_State_STATE_HOMING);
    table_.home();
    slide_.home();
    done();
  }

  void scan_load() {
    // Loading takes the ring over.
    if (scan_.active() || ring_.acked() != ring_.next_item()) {
      refuse_undelivered();
      return;
    }
    ScanPlan::Trouble trouble;
    const tg_RefuseReason reason = plan_.load(message_.body.scan_load, config_, &trouble);
    if (reason != tg_RefuseReason_REFUSE_NONE) {
      refuse(reason, trouble.what);
      if (reason == tg_RefuseReason_REFUSE_OUT_OF_RANGE) reply_.body.refused.view = trouble.view;
      return;
    }
    if (plan_.complete()) start_stream(plan_.plan_id());
    supervisor_.enter(plan_.complete() ? tg_State_STATE_ARMED : tg_State_STATE_READY);
    done();
  }

  void scan_start() {
    if (message_.body.scan_start.plan_id != plan_.plan_id()) {
      refuse(tg_RefuseReason_REFUSE_WRONG_PLAN, "another plan is loaded");
      return;
    }
    supervisor_.enter(tg_State_STATE_SCANNING);
    scan_.start(plan_);
    done();
  }

  void scan_abort() {
    if (state() == tg_State_STATE_SCANNING || state() == tg_State_STATE_PAUSED) {
      scan_.end(tg_FaultCode_FAULT_NONE);
    } else {
      // Nothing runs: forget the plan, and what the host never fetched.
      scan_.drop();
      plan_.forget();
      start_stream(0);
      supervisor_.enter(tg_State_STATE_READY);
    }
    done();
  }

  void start_stream(uint32_t plan_id) {
    ring_.start(plan_id);
    link_.obligations().stream_started();
  }

  B& board_;
  MachineConfig config_;
  uint32_t config_crc_ = 0;
  Supervisor<B> supervisor_;
  AxisMover<B> table_, slide_;
  bool homed_ = false;
  ScanPlan plan_;
  StreamRing ring_;
  ScanRunner<B> scan_;
  HostLink<B> link_;
  tg_HostMessage message_ = tg_HostMessage_init_zero;
  tg_MachineMessage reply_ = tg_MachineMessage_init_zero;
};

}  // namespace tetragauge
