// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/state_table.hpp"

namespace tetragauge {
namespace {

constexpr uint32_t bit(tg_State state) {
  return 1u << state;
}

constexpr uint32_t kIdle = bit(tg_State_STATE_IDLE), kHoming = bit(tg_State_STATE_HOMING),
                   kReady = bit(tg_State_STATE_READY), kArmed = bit(tg_State_STATE_ARMED),
                   kScanning = bit(tg_State_STATE_SCANNING), kPaused = bit(tg_State_STATE_PAUSED),
                   kFault = bit(tg_State_STATE_FAULT), kEstop = bit(tg_State_STATE_ESTOP);
constexpr uint32_t kEvery = (1u << kStates) - 1;

constexpr uint32_t kResting = kIdle | kReady | kArmed;

struct Row {
  uint32_t request;
  uint32_t states;
  uint32_t needs = 0;
};
constexpr Row kRequests[] = {
    {tg_HostMessage_hello_tag, kEvery},
    {tg_HostMessage_get_status_tag, kEvery},
    {tg_HostMessage_get_config_tag, kEvery},
    {tg_HostMessage_get_clock_tag, kEvery},
    {tg_HostMessage_get_stats_tag, kEvery},
    {tg_HostMessage_heartbeat_ack_tag, kEvery},
    {tg_HostMessage_points_credit_tag, kEvery},
    {tg_HostMessage_points_resend_tag, kEvery},
    {tg_HostMessage_clear_fault_tag, kFault | kEstop | kIdle | kReady},
    {tg_HostMessage_set_config_tag, kResting, kNeedsRest | kNeedsQuiet | kNeedsScanOver},
    {tg_HostMessage_home_tag, kResting, kNeedsRest | kNeedsQuiet | kNeedsScanOver},
    {tg_HostMessage_scan_load_tag, kReady | kArmed, kNeedsQuiet | kNeedsScanOver},
    {tg_HostMessage_measure_rays_tag, kReady | kArmed, kNeedsQuiet | kNeedsScanOver},
    {tg_HostMessage_scan_start_tag, kArmed, kNeedsRest | kNeedsQuiet},
    {tg_HostMessage_scan_pause_tag, kScanning | kPaused},
    {tg_HostMessage_scan_resume_tag, kPaused | kScanning},
    {tg_HostMessage_scan_abort_tag, kIdle | kReady | kArmed | kScanning | kPaused},
    {tg_HostMessage_jog_tag, kIdle | kReady, kNeedsQuiet},
    {tg_HostMessage_move_axis_tag, kReady, kNeedsQuiet},
    {tg_HostMessage_move_galvo_tag, kIdle | kReady | kScanning, kNeedsQuiet},
    {tg_HostMessage_laser_set_tag, kReady | kScanning | kPaused, kNeedsRest | kNeedsQuiet},
    {tg_HostMessage_calibration_read_tag, kEvery, kNeedsQuiet},
    {tg_HostMessage_calibration_write_tag, kIdle | kReady, kNeedsQuiet},
    {tg_HostMessage_calibration_commit_tag, kIdle | kReady, kNeedsRest | kNeedsQuiet | kNeedsScanOver},
    {tg_HostMessage_self_test_tag, kIdle | kReady | kFault | kEstop,
     kNeedsRest | kNeedsQuiet | kNeedsScanOver},
    {tg_HostMessage_enter_bootloader_tag, kResting | kFault | kEstop, kNeedsRest | kNeedsQuiet},
    {tg_HostMessage_reboot_tag, kResting | kFault | kEstop, kNeedsRest | kNeedsQuiet},
};

// Indexed by the state left.
constexpr uint32_t kTransitions[kStates] = {
    /* BOOT     */ kIdle | kFault | kEstop,
    /* IDLE     */ kHoming | kFault | kEstop,
    /* HOMING   */ kReady | kFault | kEstop,
    /* READY    */ kIdle | kHoming | kArmed | kScanning | kFault | kEstop,
    /* ARMED    */ kIdle | kHoming | kReady | kScanning | kFault | kEstop,
    /* SCANNING */ kReady | kPaused | kFault | kEstop,
    /* PAUSED   */ kReady | kScanning | kFault | kEstop,
    /* FAULT    */ kIdle | kReady | kEstop,
    /* ESTOP    */ kIdle,
};

}  // namespace

bool request_allowed(tg_State state, uint32_t request) {
  for (const Row& row : kRequests) {
    if (row.request == request) return (row.states & bit(state)) != 0;
  }
  return false;
}

uint32_t request_needs(uint32_t request) {
  for (const Row& row : kRequests) {
    if (row.request == request) return row.needs;
  }
  return 0;
}

bool transition_allowed(tg_State from, tg_State to) {
  return (kTransitions[from] & bit(to)) != 0;
}

}  // namespace tetragauge
