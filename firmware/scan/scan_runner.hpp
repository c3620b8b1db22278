// SPDX-License-Identifier: Apache-2.0
// Runs a plan: moves the stage to each view, measures its rays one by one, fills batches into the ring.
//
// A ray's way: mirrors written, settling, samples with the laser off, on, off, then handed over ("captured")
// to poll(), which judges it while the next one is measured. Interrupts do the former (on_alarm, on_samples),
// poll() the latter; the captured ray is the only thing between them. When poll() cannot store it because the
// ring is full, the ray after it is still finished, then measuring holds: no ray is lost and the laser is
// off.
// A raw view's rays are measured one at a time: the next begins when every sample of the last is in the ring.
#pragma once

#include "firmware/link/stream_ring.hpp"
#include "firmware/measure/judge_ray.hpp"
#include "firmware/measure/settle.hpp"
#include "firmware/motion/axis_mover.hpp"
#include "firmware/safety/supervisor.hpp"
#include "firmware/scan/raw_ray.hpp"
#include "firmware/scan/scan_plan.hpp"

namespace tetragauge {

inline constexpr uint64_t kBatchAgeNs =
    500'000'000;                               // a batch is sent at latest so long after its first beam
inline constexpr uint32_t kRailedRays = 100;   // so many in a row on a rail in the dark: FAULT_SIGNAL
inline constexpr uint32_t kRejectReasons = 8;  // room in Stats
inline constexpr uint64_t kNever = ~uint64_t{0};

template <Board B>
class ScanRunner {
 public:
  // `burst` has room for kBurstSamples; `outgoing`: where an item is made.
  ScanRunner(B& board, Supervisor<B>& supervisor, AxisMover<B>& table, AxisMover<B>& slide, StreamRing& ring,
             PsdSample* burst, tg_MachineMessage& outgoing)
      : board_(board),
        supervisor_(supervisor),
        table_(table),
        slide_(slide),
        ring_(ring),
        burst_(burst),
        item_(outgoing) {}

  void configure(const MachineConfig& config) {
    config_ = &config;
    geometry_ = geometry_of<MachineScalar>(config);
  }

  // The state is SCANNING, the ring is started for the plan.
  void start(const ScanPlan& plan) {
    plan_ = &plan;
    view_ = 0;
    points_ = rejected_ = crc_ = 0;
    inconsistent_ = railed_ = 0;
    found_ = tg_FaultCode_FAULT_NONE;
    have_captured_ = false;
    have_record_ = ending_ = flush_wanted_ = false;
    active_ = true;
    go_to_view();
  }

  // Until ScanEnd is in the ring.
  bool active() const { return active_; }
  uint32_t view() const { return view_; }
  uint32_t ray() const { return ray_; }

  // Mirrors as driven, and driven without a ray to measure.
  int32_t a_urad() const { return a_code_ * kUradPerMirrorCode; }
  int32_t b_urad() const { return b_code_ * kUradPerMirrorCode; }
  void aim(RayTarget target) {
    a_code_ = mirror_code(target.a_urad, B::kMirrorCodeStep);
    b_code_ = mirror_code(target.b_urad, B::kMirrorCodeStep);
    board_.set_mirrors(static_cast<int16_t>(a_code_), static_cast<int16_t>(b_code_));
  }

  // The converter works on a burst: nobody else may start one.
  bool sampling() const { return burst_running_; }
  // Since start-up; by RejectReason.
  struct Tally {
    uint32_t points = 0, unsettled = 0, rejected[kRejectReasons] = {};
  };
  const Tally& tally() const { return tally_; }

  // Drops the ray under way; it is measured again whole when the state is SCANNING again.
  void interrupt_ray() {
    board_.mask_interrupts(true);
    supervisor_.laser_off();
    if (phase_ == Phase::kStageSettle) {
      phase_ = Phase::kMoveStage;
    } else if (phase_ != Phase::kNone && phase_ != Phase::kMoveStage && phase_ != Phase::kHold &&
               phase_ != Phase::kViewDone) {
      phase_ = Phase::kNextRay;
    }
    board_.mask_interrupts(false);
    flush_wanted_ = true;
  }

  // Ends the scan early; ScanEnd follows as soon as the ring has room.
  void end(tg_FaultCode fault) {
    if (!active_ || ending_) return;
    interrupt_ray();
    ending_ = true;
    end_fault_ = fault;
  }

  // Forgets a scan that has ended, with what the host never fetched of it.
  void drop() {
    phase_ = Phase::kNone;
    active_ = false;
  }

  // A fault that measuring has found; FAULT_NONE otherwise.
  tg_FaultCode poll() {
    if (!active_) return tg_FaultCode_FAULT_NONE;
    if (burst_running_ && board_.now_ns() > burst_deadline_ns_) {
      burst_running_ = false;
      return tg_FaultCode_FAULT_SAMPLING;
    }
    if (have_captured_) store_captured();
    if (flush_wanted_ && !have_captured_ && flush()) flush_wanted_ = false;
    if (board_.now_ns() >= batch_due_ns_) flush();
    if (ending_) {
      if (!have_captured_ && flush()) finish(true);
    } else if (supervisor_.state() == tg_State_STATE_SCANNING) {
      advance();
    }
    const tg_FaultCode found = found_;
    found_ = tg_FaultCode_FAULT_NONE;
    return found;
  }

  uint64_t next_poll_ns() const {
    uint64_t next = active_ && burst_running_ ? burst_deadline_ns_ + 1 : kNever;
    if (active_ && !builder_.empty() && !ring_.full() && batch_due_ns_ < next) next = batch_due_ns_;
    return next;
  }

  void on_alarm() {
    switch (phase_) {
      case Phase::kStageSettle:
        phase_ = Phase::kNextRay;
        break;
      case Phase::kMirrorSettle:
        take_samples(Phase::kOffBefore, samples_per_phase() / 2);
        break;
      case Phase::kLaserRise:
        if (config_->measure.stable_codes > 0) {
          stability_.start(board_.now_ns());
          take_samples(Phase::kStable, kStableSamples);
        } else {
          take_samples(Phase::kOn, samples_per_phase());
        }
        break;
      case Phase::kLaserFall:
        take_samples(Phase::kOffAfter, samples_per_phase() / 2);
        break;
      default:
        break;  // the alarm of a ray that was interrupted
    }
  }

  void on_samples() {
    burst_running_ = false;
    if (burst_phase_ != phase_ || burst_number_ != ray_number_) return;  // its ray was interrupted
    if (phase_ == Phase::kStable) {
      watch_settling();
      return;
    }
    const Light light = phase_ == Phase::kOffBefore ? Light::kOffBefore
                        : phase_ == Phase::kOn      ? Light::kOn
                                                    : Light::kOffAfter;
    const int32_t rail = static_cast<int32_t>(config_->measure.rail_codes);
    samples_.add(light, burst_, burst_count_, rail, config_->measure.trim_permille);
    if (current_view().raw) raw_.add(burst_, burst_count_);
    remaining_ -= burst_count_;
    if (remaining_ > 0) {
      take_samples(phase_, remaining_);
    } else if (phase_ == Phase::kOffBefore) {
      if (supervisor_.laser_on()) {
        wait(Phase::kLaserRise, config_->measure.laser_delay_us);
      } else {
        phase_ = Phase::kNextRay;  // the controller is about to pause or to fail
      }
    } else if (phase_ == Phase::kOn) {
      supervisor_.laser_off();
      wait(Phase::kLaserFall, config_->measure.laser_delay_us);
    } else {
      ray_done();
    }
  }

 private:
  enum class Phase : uint8_t {
    kNone,
    kMoveStage,
    kStageSettle,
    kNextRay,  // poll() starts it
    kMirrorSettle,
    kOffBefore,
    kLaserRise,
    kStable,  // until the spot stands still
    kOn,
    kLaserFall,
    kOffAfter,
    kHold,  // a whole ray waits for the captured one to be stored
    kViewDone,
  };

  const tg_View& current_view() const { return plan_->view(view_); }
  uint32_t samples_per_phase() const { return current_view().samples; }

  void wait(Phase phase, uint32_t us) {
    phase_ = phase;
    board_.set_alarm_ns(board_.now_ns() + uint64_t{us} * 1000);
  }

  void take_samples(Phase phase, uint32_t count) {
    phase_ = phase;
    remaining_ = count;
    burst_count_ = count < kBurstSamples ? count : kBurstSamples;
    burst_phase_ = phase;
    burst_number_ = ray_number_;
    burst_running_ = true;
    // Twice its time and a millisecond: a converter that late has stopped.
    burst_deadline_ns_ = board_.now_ns() + 2 * uint64_t{burst_count_} * B::kSamplePeriodNs + 1'000'000;
    board_.start_samples(burst_, burst_count_);
  }

  void watch_settling() {
    const bool stable = stability_.add(burst_, burst_count_, config_->measure.stable_codes);
    const uint64_t longest_ns = uint64_t{config_->measure.stable_max_us} * 1000;
    if (!stable && board_.now_ns() - stability_.since_ns() < longest_ns) {
      take_samples(Phase::kStable, kStableSamples);
      return;
    }
    settled_ = settled_ && stable;
    take_samples(Phase::kOn, samples_per_phase());
  }

  void go_to_view() {
    ray_ = 0;
    phase_ = Phase::kMoveStage;
    const tg_View& view = current_view();
    const bool reachable = table_.move_to(table_steps(*config_, view.table_udeg)) &&
                           slide_.move_to(slide_steps(*config_, view.slide_um));
    if (!reachable) found_ = tg_FaultCode_FAULT_LIMIT;
  }

  // What poll() does towards the next ray.
  void advance() {
    if (phase_ == Phase::kMoveStage && !table_.busy() && !slide_.busy()) {
      table_udeg_ = table_udeg(*config_, table_.position_steps());
      slide_um_ = slide_um(*config_, slide_.position_steps());
      builder_.start(ring_.plan_id(), view_, table_udeg_, slide_um_);
      wait(Phase::kStageSettle, config_->measure.stage_settle_us);
    } else if (phase_ == Phase::kNextRay && !burst_running_ && !raw_pending()) {
      board_.mask_interrupts(true);
      start_ray();
      board_.mask_interrupts(false);
    } else if (phase_ == Phase::kViewDone && !have_captured_ && flush()) {
      if (view_ + 1 < plan_->views()) {
        ++view_;
        go_to_view();
      } else {
        finish(false);
      }
    }
  }

  void start_ray() {
    const int32_t a_before = a_code_, b_before = b_code_;
    ++ray_number_;
    samples_ = {};
    if (current_view().raw) raw_.start(samples_per_phase());
    aim(plan_->target(view_, ray_));
    const int32_t a_step = absolute(a_code_ - a_before), b_step = absolute(b_code_ - b_before);
    const Settling settling =
        settling_of(config_->measure, kUradPerMirrorCode * (a_step > b_step ? a_step : b_step));
    settled_ = settling.enough;
    wait(Phase::kMirrorSettle, settling.us);
  }

  void ray_done() {
    if (have_captured_) {
      phase_ = Phase::kHold;
      return;
    }
    captured_ = samples_;
    captured_place_ = {view_, ray_, a_urad(), b_urad(), settled_};
    have_captured_ = true;
    ++ray_;
    if (ray_ == plan_->rays(view_)) {
      phase_ = Phase::kViewDone;
    } else if (supervisor_.state() == tg_State_STATE_SCANNING && !raw_pending()) {
      start_ray();
    } else {
      phase_ = Phase::kNextRay;
    }
  }

  void store_captured() {
    if (!have_record_) {
      constexpr double kRadPerUdeg = 3.14159265358979323846 / 180e6;
      const StagePlace stage{static_cast<MachineScalar>(table_udeg_ * kRadPerUdeg),
                             static_cast<MachineScalar>(slide_um_ * 1e-3)};
      record_ = judge_ray(geometry_, config_->measure, stage, captured_place_, captured_);
      have_record_ = true;
      watch_for_failure();
    }
    while (raw_pending() && raw_.left() > 0) {
      if (!push_raw()) return;
    }
    const bool first = builder_.empty();
    if (!builder_.add(record_)) {
      if (!flush()) return;
      batch_due_ns_ = board_.now_ns() + kBatchAgeNs;
      builder_.add(record_);  // an empty batch takes any beam
    } else if (first) {
      batch_due_ns_ = board_.now_ns() + kBatchAgeNs;
    }
    crc_ = crc_of_beam(record_, crc_);
    ++(record_.reason == 0 ? points_ : rejected_);
    ++(record_.reason == 0 ? tally_.points : tally_.rejected[record_.reason % kRejectReasons]);
    if (record_.reason == 0 && (record_.flags & tg_PointFlag_POINT_UNSETTLED)) ++tally_.unsettled;
    board_.mask_interrupts(true);
    have_record_ = false;
    have_captured_ = false;
    if (phase_ == Phase::kHold) ray_done();
    board_.mask_interrupts(false);
  }

  void watch_for_failure() {
    const uint32_t in_the_dark = captured_.on_rail(Light::kOffBefore) | captured_.on_rail(Light::kOffAfter);
    railed_ = in_the_dark != 0 ? railed_ + 1 : 0;
    if (record_.reason == tg_RejectReason_REJECT_INCONSISTENT) ++inconsistent_;
    // A spot that one camera alone sees, or faintly, agrees with any geometry.
    constexpr uint32_t kNoWitness = tg_PointFlag_POINT_ONE_CAMERA | tg_PointFlag_POINT_WEAK;
    if (record_.reason == 0 && (record_.flags & kNoWitness) == 0) inconsistent_ = 0;
    if (railed_ >= kRailedRays) found_ = tg_FaultCode_FAULT_SIGNAL;
    if (inconsistent_ >= config_->measure.misassembled_after) found_ = tg_FaultCode_FAULT_MISASSEMBLED;
  }

  // A captured ray whose samples leave with it.
  bool raw_pending() const { return have_captured_ && plan_->view(captured_place_.view).raw; }

  // False when the ring is full.
  bool push_raw() {
    if (ring_.full()) return false;
    item_ = tg_MachineMessage_init_zero;
    item_.which_body = tg_MachineMessage_raw_samples_tag;
    tg_RawSamples& message = item_.body.raw_samples;
    message.plan_id = ring_.plan_id();
    message.view = captured_place_.view;
    message.ray = captured_place_.ray;
    raw_.take(&message);
    ring_.push(item_);
    return true;
  }

  // False when the ring is full.
  bool flush() {
    if (builder_.empty()) return true;
    if (ring_.full()) return false;
    item_ = tg_MachineMessage_init_zero;
    item_.which_body = tg_MachineMessage_points_tag;
    item_.body.points = builder_.batch();
    ring_.push(item_);
    builder_.start(ring_.plan_id(), view_, table_udeg_, slide_um_);
    return true;
  }

  void finish(bool aborted) {
    if (ring_.full()) return;
    item_ = tg_MachineMessage_init_zero;
    item_.which_body = tg_MachineMessage_scan_end_tag;
    item_.body.scan_end = {ring_.plan_id(),
                           aborted,
                           aborted ? end_fault_ : tg_FaultCode_FAULT_NONE,
                           points_,
                           rejected_,
                           crc_,
                           board_.now_ns() / 1000};
    ring_.push(item_);
    phase_ = Phase::kNone;
    active_ = false;
  }

  static int32_t absolute(int32_t x) { return x < 0 ? -x : x; }

  B& board_;
  Supervisor<B>& supervisor_;
  AxisMover<B>& table_;
  AxisMover<B>& slide_;
  StreamRing& ring_;
  PsdSample* const burst_;
  tg_MachineMessage& item_;
  const MachineConfig* config_ = nullptr;
  MachineGeometry<MachineScalar> geometry_;
  const ScanPlan* plan_ = nullptr;

  bool active_ = false, ending_ = false, flush_wanted_ = false;
  tg_FaultCode end_fault_ = tg_FaultCode_FAULT_NONE;
  tg_FaultCode found_ = tg_FaultCode_FAULT_NONE;
  volatile Phase phase_ = Phase::kNone;
  uint32_t view_ = 0, ray_ = 0;
  int32_t table_udeg_ = 0, slide_um_ = 0;  // as the stage stands in this view

  uint32_t ray_number_ = 0;  // counts every start of a ray
  int32_t a_code_ = 0, b_code_ = 0;
  bool settled_ = true;
  SpotStability stability_;
  RaySamples samples_;
  uint32_t burst_count_ = 0, remaining_ = 0, burst_number_ = 0;
  Phase burst_phase_ = Phase::kNone;
  volatile bool burst_running_ = false;
  uint64_t burst_deadline_ns_ = 0;

  volatile bool have_captured_ = false;
  RaySamples captured_;
  RawRay<kMaxRawSamples> raw_;
  RayPlace captured_place_;
  bool have_record_ = false;
  BeamRecord record_;

  BatchBuilder builder_;
  uint64_t batch_due_ns_ = 0;
  uint32_t points_ = 0, rejected_ = 0, crc_ = 0;
  Tally tally_;
  uint32_t inconsistent_ = 0, railed_ = 0;
};

}  // namespace tetragauge
