// SPDX-License-Identifier: GPL-3.0-or-later
// The protocol's codes in words for a person: what happened, and what to do next.
#pragma once

#include <string>
#include <string_view>

#include "protocol/machine.pb.h"

namespace tetragauge {

std::string_view explain_fault(tg_FaultCode code);
std::string_view explain_reject(uint32_t reason);

// Nothing when host and machine fit together; else which image to flash and how.
std::string explain_mismatch(const tg_HelloReply& machine);

}  // namespace tetragauge
