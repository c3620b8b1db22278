// SPDX-License-Identifier: Apache-2.0
// A state in one word, the same on both ends of the line.
#pragma once

#include "protocol/machine.pb.h"

namespace tetragauge {

inline const char* state_name(tg_State state) {
  switch (state) {
    case tg_State_STATE_BOOT:
      return "BOOT";
    case tg_State_STATE_IDLE:
      return "IDLE";
    case tg_State_STATE_HOMING:
      return "HOMING";
    case tg_State_STATE_READY:
      return "READY";
    case tg_State_STATE_ARMED:
      return "ARMED";
    case tg_State_STATE_SCANNING:
      return "SCANNING";
    case tg_State_STATE_PAUSED:
      return "PAUSED";
    case tg_State_STATE_FAULT:
      return "FAULT";
    case tg_State_STATE_ESTOP:
      return "ESTOP";
  }
  return "unknown";  // of a newer machine
}

}  // namespace tetragauge
