// SPDX-License-Identifier: Apache-2.0
// One request of the host, executed and answered: first the table of states (safety/state_table.hpp), then
// one function for each. A request that takes time (SelfTest, CalibrationCommit) is answered later.
#pragma once

#include "firmware/report_state.hpp"
#include "protocol/state_name.hpp"

namespace tetragauge {

template <Board B>
class RequestAnswerer {
 public:
  explicit RequestAnswerer(Machine<B>& machine) : m_(machine) {}

  // `reply` is init_zero. False: the reply comes later, from finish().
  bool answer(const tg_HostMessage& request, tg_MachineMessage* reply) {
    reply_ = reply;
    later_ = false;
    if (may_be_executed(request.which_body)) execute(request);
    return !later_;
  }

  void refuse(tg_MachineMessage* reply, tg_RefuseReason reason, const char* detail) {
    reply_ = reply;
    refuse(reason, detail);
  }

  // The answer to the request that took time, when it is over; false when there is none.
  bool finish(tg_MachineMessage* reply) {
    if (waiting_for_ == 0 || m_.self_test.running() || m_.store.busy()) return false;
    *reply = tg_MachineMessage_init_zero;
    reply_ = reply;
    if (waiting_for_ == tg_HostMessage_self_test_tag) {
      reply_->which_body = tg_MachineMessage_self_test_tag;
      reply_->body.self_test = m_.self_test.reply();
    } else {
      calibration_commit_over();
    }
    waiting_for_ = 0;
    return true;
  }

 private:
  void done() { reply_->which_body = tg_MachineMessage_done_tag; }
  void refuse(tg_RefuseReason reason, const char* detail) {
    *reply_ = tg_MachineMessage_init_zero;
    reply_->which_body = tg_MachineMessage_refused_tag;
    tg_Refused& refused = reply_->body.refused;
    refused.reason = reason;
    refused.state = m_.state();
    copy_text(refused.detail, sizeof refused.detail, detail);
  }
  void refuse_undelivered() {
    refuse(tg_RefuseReason_REFUSE_UNDELIVERED, "acknowledge the last scan's items, or ScanAbort drops them");
  }
  void answer_when_over(uint32_t request) {
    waiting_for_ = request;
    later_ = true;
  }

  bool may_be_executed(uint32_t request) {
    if (!request_allowed(m_.state(), request)) {
      refuse(tg_RefuseReason_REFUSE_STATE, state_name(m_.state()));
      return false;
    }
    const uint32_t needs = request_needs(request);
    if ((needs & kNeedsQuiet) && m_.self_test.running()) {
      refuse(tg_RefuseReason_REFUSE_BUSY, "a self-test runs");
    } else if ((needs & kNeedsQuiet) && m_.store.busy()) {
      refuse(tg_RefuseReason_REFUSE_BUSY, "a calibration is being stored");
    } else if ((needs & kNeedsRest) && m_.moving()) {
      refuse(tg_RefuseReason_REFUSE_BUSY, "an axis moves; wait, or ScanAbort stops it");
    } else if ((needs & kNeedsScanOver) && m_.scan.active()) {
      // After a fault: the end of the broken scan waits for room in the ring, and its rays for their
      // geometry.
      refuse_undelivered();
    } else {
      return true;
    }
    return false;
  }

  void execute(const tg_HostMessage& request) {
    switch (request.which_body) {
      case tg_HostMessage_hello_tag:
        m_.link.forget_replies();
        m_.link.start_heartbeats();
        reply_->which_body = tg_MachineMessage_hello_reply_tag;
        report_hello(m_, reply_->body.hello_reply);
        break;
      case tg_HostMessage_get_status_tag:
        reply_->which_body = tg_MachineMessage_status_tag;
        report_status(m_, reply_->body.status);
        break;
      case tg_HostMessage_get_clock_tag:
        reply_->which_body = tg_MachineMessage_clock_tag;
        reply_->body.clock.clock_us = m_.board.now_ns() / 1000;
        break;
      case tg_HostMessage_get_stats_tag:
        reply_->which_body = tg_MachineMessage_stats_tag;
        report_stats(m_, reply_->body.stats);
        break;
      case tg_HostMessage_get_config_tag:
        get_config(request.body.get_config);
        break;
      case tg_HostMessage_set_config_tag:
        set_config(request.body.set_config);
        break;
      case tg_HostMessage_clear_fault_tag:
        clear_fault();
        break;
      case tg_HostMessage_home_tag:
        home();
        break;
      case tg_HostMessage_jog_tag:
        jog(request.body.jog);
        break;
      case tg_HostMessage_move_axis_tag:
        move_axis(request.body.move_axis);
        break;
      case tg_HostMessage_move_galvo_tag:
        move_galvo(request.body.move_galvo);
        break;
      case tg_HostMessage_laser_set_tag:
        laser_set(request.body.laser_set.on);
        break;
      case tg_HostMessage_scan_load_tag:
        load(request.body.scan_load);
        break;
      case tg_HostMessage_measure_rays_tag:
        load(request.body.measure_rays);
        break;
      case tg_HostMessage_scan_start_tag:
        scan_start(request.body.scan_start);
        break;
      case tg_HostMessage_scan_pause_tag:
        if (m_.state() == tg_State_STATE_SCANNING) m_.pause();
        done();
        break;
      case tg_HostMessage_scan_resume_tag:
        m_.supervisor.enter(tg_State_STATE_SCANNING);
        if (m_.aiming) m_.supervisor.laser_on();
        done();
        break;
      case tg_HostMessage_scan_abort_tag:
        scan_abort();
        break;
      case tg_HostMessage_calibration_read_tag:
        calibration_read(request.body.calibration_read);
        break;
      case tg_HostMessage_calibration_write_tag:
        if (const char* error = m_.store.write(request.body.calibration_write)) {
          refuse(tg_RefuseReason_REFUSE_STORAGE, error);
        } else {
          done();
        }
        break;
      case tg_HostMessage_calibration_commit_tag:
        calibration_commit(request.body.calibration_commit);
        break;
      case tg_HostMessage_self_test_tag:
        m_.supervisor.laser_off();
        m_.self_test.start(m_.config);
        answer_when_over(tg_HostMessage_self_test_tag);
        break;
      case tg_HostMessage_enter_bootloader_tag:
        m_.leaving = Machine<B>::Leaving::kBootloader;
        done();
        break;
      case tg_HostMessage_reboot_tag:
        m_.leaving = Machine<B>::Leaving::kReboot;
        done();
        break;
      default:
        refuse(tg_RefuseReason_REFUSE_UNKNOWN, "is an event, or unknown to this firmware");
        break;
    }
  }

  // ---------------------------------------------------------------- configuration

  void get_config(const tg_GetConfig& get) {
    tg_Config part = tg_Config_init_zero;
    if (!get_part(m_.config, get.part, &part)) {
      refuse(tg_RefuseReason_REFUSE_OUT_OF_RANGE, "no such part of the configuration");
      return;
    }
    reply_->which_body = tg_MachineMessage_config_tag;
    reply_->body.config = part;
  }

  void set_config(const tg_Config& part) {
    if (const char* error = config_error(part)) {
      refuse(tg_RefuseReason_REFUSE_OUT_OF_RANGE, error);
      return;
    }
    set_part(&m_.config, part);
    m_.use_config();
    m_.plan.forget();
    if (part.which_part == tg_Config_stage_tag) m_.homed = false;
    m_.supervisor.enter(m_.homed ? tg_State_STATE_READY : tg_State_STATE_IDLE);
    done();
  }

  void calibration_read(const tg_CalibrationRead& read) {
    const uint32_t total = m_.store.total();
    if (read.offset > total) {
      refuse(tg_RefuseReason_REFUSE_OUT_OF_RANGE, "offset is beyond the record");
      return;
    }
    reply_->which_body = tg_MachineMessage_calibration_tag;
    tg_CalibrationChunk& chunk = reply_->body.calibration;
    chunk.offset = read.offset;
    chunk.total = total;
    chunk.crc = m_.store.crc();
    const uint32_t left = total - read.offset;
    const uint32_t bytes =
        left < sizeof chunk.data.bytes ? left : static_cast<uint32_t>(sizeof chunk.data.bytes);
    chunk.data.size = static_cast<pb_size_t>(bytes);
    m_.store.read(read.offset, chunk.data.bytes, bytes);
  }

  void calibration_commit(const tg_CalibrationCommit& commit) {
    const char* error = m_.store.commit_error(commit);
    if (error == nullptr && commit.total > 0) {
      tg_Calibration calibration = tg_Calibration_init_zero;
      error = decode_calibration(m_.store.written(), commit.total, &calibration)
                  ? calibration_error(calibration)
                  : "the record does not decode";
    }
    if (error != nullptr) {
      refuse(tg_RefuseReason_REFUSE_STORAGE, error);
      return;
    }
    m_.store.commit(commit);
    answer_when_over(tg_HostMessage_calibration_commit_tag);
  }

  void calibration_commit_over() {
    if (m_.store.outcome() == CalibrationStore::Outcome::kFailed) {
      m_.fail(tg_FaultCode_FAULT_STORAGE);  // before the refusal: both are made in one place
      refuse(tg_RefuseReason_REFUSE_STORAGE,
             "the store does not take it; the calibration before is still in force");
      return;
    }
    if (m_.store.outcome() == CalibrationStore::Outcome::kOneCopy) {
      m_.link.log(tg_LogLevel_LOG_WARNING, "calibration: only one of its two copies could be stored");
    }
    m_.calibration_stored();
    done();
  }

  void clear_fault() {
    if (m_.state() != tg_State_STATE_FAULT && m_.state() != tg_State_STATE_ESTOP) {
      done();
    } else if (m_.supervisor.clear(m_.homed ? tg_State_STATE_READY : tg_State_STATE_IDLE)) {
      done();
    } else {
      refuse(tg_RefuseReason_REFUSE_STILL_FAULTY,
             "the cause is still there: interlock, mirror or laser driver");
    }
  }

  // ---------------------------------------------------------------- motion and light

  void home() {
    m_.plan.forget();
    m_.homed = false;
    m_.supervisor.enter(tg_State_STATE_HOMING);
    m_.table.home();
    m_.slide.home();
    done();
  }

  struct AxisPlace {
    AxisMover<B>* axis;
    const tg_AxisMotion* motion;
    int64_t (*steps)(const MachineConfig&, int32_t);
  };
  // Null axis when the request is refused.
  AxisPlace axis_at_rest(tg_AxisName name) {
    AxisPlace place{nullptr, nullptr, nullptr};
    if (name == tg_AxisName_AXIS_TABLE) {
      place = {&m_.table, &m_.config.stage.table, &table_steps};
    } else if (name == tg_AxisName_AXIS_SLIDE) {
      place = {&m_.slide, &m_.config.stage.slide, &slide_steps};
    } else {
      refuse(tg_RefuseReason_REFUSE_OUT_OF_RANGE, "axis must be AXIS_TABLE or AXIS_SLIDE");
    }
    if (place.axis != nullptr && place.axis->busy()) {
      refuse(tg_RefuseReason_REFUSE_BUSY, "this axis moves; wait, or ScanAbort stops it");
      place.axis = nullptr;
    }
    return place;
  }

  void jog(const tg_Jog& jog) {
    const AxisPlace place = axis_at_rest(jog.axis);
    if (place.axis == nullptr) return;
    int64_t target = place.axis->position_steps() + place.steps(m_.config, jog.by);
    if (m_.homed) {
      if (target < place.motion->min_steps) target = place.motion->min_steps;
      if (target > place.motion->max_steps) target = place.motion->max_steps;
      place.axis->move_to(target);
    } else {
      place.axis->jog_to(target);
    }
    done();
  }

  void move_axis(const tg_MoveAxis& move) {
    const AxisPlace place = axis_at_rest(move.axis);
    if (place.axis == nullptr) return;
    const int64_t target = place.steps(m_.config, move.to);
    if (target < place.motion->min_steps || target > place.motion->max_steps) {
      refuse(tg_RefuseReason_REFUSE_OUT_OF_RANGE, "to is beyond the axis' soft limits");
      return;
    }
    place.axis->move_to(target);
    done();
  }

  bool scan_runs() const {
    return !m_.aiming && (m_.state() == tg_State_STATE_SCANNING || m_.state() == tg_State_STATE_PAUSED);
  }

  void move_galvo(const tg_MoveGalvo& move) {
    const int32_t limit = m_.config.galvo.limit_urad;
    if (scan_runs()) {
      refuse(tg_RefuseReason_REFUSE_BUSY, "a scan runs");
    } else if (move.a_urad < -limit || move.a_urad > limit || move.b_urad < -limit || move.b_urad > limit) {
      refuse(tg_RefuseReason_REFUSE_OUT_OF_RANGE, "an angle is beyond the mirrors' limit");
    } else {
      m_.scan.aim({move.a_urad, move.b_urad});
      done();
    }
  }

  void laser_set(bool on) {
    if (scan_runs()) {
      refuse(tg_RefuseReason_REFUSE_BUSY, "a scan runs");
      return;
    }
    if (!on) {
      if (m_.aiming) m_.stop_aiming();
    } else if (m_.state() == tg_State_STATE_READY) {
      if (m_.scan.active()) {
        refuse_undelivered();
        return;
      }
      m_.aiming = true;
      m_.supervisor.enter(tg_State_STATE_SCANNING);
      m_.supervisor.laser_on();
    } else if (m_.state() == tg_State_STATE_PAUSED) {
      refuse(tg_RefuseReason_REFUSE_STATE, "PAUSED; ScanResume turns the laser on again");
      return;
    }
    done();
  }

  // ---------------------------------------------------------------- scan

  template <class Chunk>
  void load(const Chunk& chunk) {
    // Loading takes the ring over.
    if (m_.ring.acked() != m_.ring.next_item()) {
      refuse_undelivered();
      return;
    }
    ScanPlan::Trouble trouble;
    const tg_RefuseReason reason = m_.plan.load(chunk, m_.config, &trouble);
    if (reason != tg_RefuseReason_REFUSE_NONE) {
      refuse(reason, trouble.what);
      if (reason == tg_RefuseReason_REFUSE_OUT_OF_RANGE) reply_->body.refused.view = trouble.view;
      return;
    }
    if (m_.plan.complete()) m_.start_stream(m_.plan.plan_id());
    m_.supervisor.enter(m_.plan.complete() ? tg_State_STATE_ARMED : tg_State_STATE_READY);
    done();
  }

  void scan_start(const tg_ScanStart& start) {
    if (start.plan_id != m_.plan.plan_id()) {
      refuse(tg_RefuseReason_REFUSE_WRONG_PLAN, "another plan is loaded");
      return;
    }
    m_.supervisor.enter(tg_State_STATE_SCANNING);
    m_.scan.start(m_.plan);
    done();
  }

  void scan_abort() {
    if (scan_runs()) {
      m_.scan.end(tg_FaultCode_FAULT_NONE);
    } else if (m_.aiming) {
      m_.stop_aiming();
    } else {
      // Nothing runs: stop the axes, forget the plan, and what the host never fetched.
      m_.table.stop();
      m_.slide.stop();
      m_.scan.drop();
      m_.plan.forget();
      m_.start_stream(0);
      if (m_.state() == tg_State_STATE_ARMED) m_.supervisor.enter(tg_State_STATE_READY);
    }
    done();
  }

  Machine<B>& m_;
  tg_MachineMessage* reply_ = nullptr;
  bool later_ = false;
  uint32_t waiting_for_ = 0;  // request whose answer is due, 0: none
};

}  // namespace tetragauge
