// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tetragauge {

inline constexpr const char* kFirmwareVersion = "0.1.0";

}  // namespace tetragauge
