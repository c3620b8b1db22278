// SPDX-License-Identifier: Apache-2.0
// Which requests are legal in which state and what they need besides, and which changes of state there are
// (protocol/README.md has them as tables and as a picture; a test compares).
#pragma once

#include <cstdint>

#include "protocol/machine.pb.h"

namespace tetragauge {

inline constexpr int kStates = 9;

// `request` is the tag of HostMessage's body, e.g. tg_HostMessage_home_tag.
bool request_allowed(tg_State state, uint32_t request);

// Bits of what must hold, in a legal state, before a request is executed.
inline constexpr uint32_t kNeedsRest = 1;  // no axis moves; else REFUSE_BUSY
inline constexpr uint32_t kNeedsQuiet =
    2;  // no self-test runs, no calibration is being stored; else REFUSE_BUSY
inline constexpr uint32_t kNeedsScanOver = 4;  // the last scan's end is in the ring; else REFUSE_UNDELIVERED
uint32_t request_needs(uint32_t request);

bool transition_allowed(tg_State from, tg_State to);

}  // namespace tetragauge
