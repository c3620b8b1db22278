// SPDX-License-Identifier: Apache-2.0
// The parts of the machine, and what concerns several of them at once: faults, pausing, which configuration
// is in force. Requests come in from answer_request.hpp, time and interrupts from controller.hpp.
#pragma once

#include "firmware/link/host_link.hpp"
#include "firmware/machine_config.hpp"
#include "firmware/motion/axis_mover.hpp"
#include "firmware/safety/self_test.hpp"
#include "firmware/safety/supervisor.hpp"
#include "firmware/scan/scan_runner.hpp"
#include "firmware/storage/calibration_store.hpp"

namespace tetragauge {

// The calibration's name is claimed as long as the configuration in force is the calibration's, number by
// number: SetConfig ends the claim, and setting the old numbers again restores it.
struct CalibrationClaim {
  char id[sizeof tg_Calibration::id] = {};
  uint32_t u_cal_100nm = 0;
  uint32_t config_crc = 0;
};

template <Board B>
struct Machine {
  explicit Machine(B& the_board)
      : board(the_board),
        supervisor(the_board),
        table(the_board, Axis::kTable, Inputs::kTableHome),
        slide(the_board, Axis::kSlide, Inputs::kSlideHome),
        scan(the_board, supervisor, table, slide, ring, burst, outgoing),
        link(the_board, ring, outgoing),
        store(the_board.storage()),
        self_test(the_board, store, burst) {}
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  B& board;
  // The one message being made, whoever makes it: filled and encoded with nothing in between.
  tg_MachineMessage outgoing = tg_MachineMessage_init_zero;
  // The converter's: of a scan or of the self-test, which never run together.
  PsdSample burst[kBurstSamples] = {};
  MachineConfig config;
  uint32_t config_crc = 0;
  Supervisor<B> supervisor;
  AxisMover<B> table, slide;
  bool homed = false;
  ScanPlan plan;
  StreamRing ring;
  ScanRunner<B> scan;
  bool aiming = false;  // SCANNING or PAUSED by LaserSet, with no scan
  HostLink<B> link;
  CalibrationStore store;
  CalibrationClaim claim;
  SelfTest<B> self_test;
  enum class Leaving : uint8_t { kNo, kReboot, kBootloader } leaving = Leaving::kNo;
  uint32_t silences = 0, faults = 0, longest_poll_us = 0;

  tg_State state() const { return supervisor.state(); }
  bool moving() const { return table.busy() || slide.busy(); }
  bool calibrated() const { return claim.id[0] != '\0' && claim.config_crc == config_crc; }

  void fail(tg_FaultCode code) {
    // A stage stopped in the middle of a move has lost steps; and what opens the interlock takes the motors'
    // current away, too (docs/machine.md), after which they stand anywhere.
    if (moving() || code == tg_FaultCode_FAULT_INTERLOCK) homed = false;
    table.halt();
    slide.halt();
    const bool is_new = supervisor.latch(code);
    aiming = false;
    scan.end(code);
    plan.forget();
    if (!is_new) return;
    ++faults;
    tg_Fault event = tg_Fault_init_zero;
    event.code = code;
    event.clock_us = supervisor.fault_clock_us();
    link.fault(event);
  }

  void pause() {
    supervisor.enter(tg_State_STATE_PAUSED);
    if (!aiming) scan.interrupt_ray();
  }

  void stop_aiming() {
    aiming = false;
    supervisor.enter(tg_State_STATE_READY);
  }

  void start_stream(uint32_t plan_id) { ring.start(plan_id); }

  void use_config() {
    table.configure(config.stage.table);
    slide.configure(config.stage.slide);
    scan.configure(config);
    config_crc = tetragauge::config_crc(config);
  }

  // The record in the store, or nominal numbers without a usable one.
  void use_stored_calibration() {
    use_nominal_numbers();
    if (store.total() == 0) {
      link.log(tg_LogLevel_LOG_INFO, "no calibration in the store: nominal numbers are in use");
    } else if (!load_calibration()) {
      link.log(tg_LogLevel_LOG_ERROR, "the stored calibration does not suit this firmware: calibrate again");
    }
    use_config();
    claim.config_crc = config_crc;
  }

  // These two are not inlined: their records are off the stack before the configuration is worked with.
  [[gnu::noinline]] void use_nominal_numbers() {
    claim = {};
    config = nominal_config();
    if (config.galvo.limit_urad > B::kMirrorReachUrad) config.galvo.limit_urad = B::kMirrorReachUrad;
  }
  [[gnu::noinline]] bool load_calibration() {
    tg_Calibration calibration = tg_Calibration_init_zero;
    if (!decode_calibration(store.load(), store.total(), &calibration)) return false;
    if (calibration_error(calibration) != nullptr) return false;
    use_calibration(calibration, &config);
    for (size_t i = 0; i < sizeof claim.id; ++i) claim.id[i] = calibration.id[i];
    claim.u_cal_100nm = calibration.u_cal_100nm;
    return true;
  }

  void calibration_stored() {
    plan.forget();
    homed = false;
    use_stored_calibration();
    // A fault that came meanwhile stays.
    if (state() == tg_State_STATE_READY) supervisor.enter(tg_State_STATE_IDLE);
  }
};

}  // namespace tetragauge
