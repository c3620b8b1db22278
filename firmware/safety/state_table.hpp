// SPDX-License-Identifier: Apache-2.0
// Which requests are legal in which state, and which changes of state there are (protocol/README.md has them
// as a picture).
#pragma once

#include <cstdint>

#include "protocol/machine.pb.h"

namespace tetragauge {

inline constexpr int kStates = 9;

// `request` is the tag of HostMessage's body, e.g. tg_HostMessage_home_tag.
bool request_allowed(tg_State state, uint32_t request);

bool transition_allowed(tg_State from, tg_State to);

// In words, for Refused.detail and logs.

}  // namespace tetragauge
