// SPDX-License-Identifier: Apache-2.0
// How long the mirrors need after a step. A galvanometer's settling time is nearly constant for small steps
// and grows with the step for large ones, where its drive limits the speed: base + per_mrad * step.
#pragma once

#include <cstdint>

#include "protocol/machine.pb.h"

namespace tetragauge {

struct Settling {
  uint32_t us = 0;
  bool enough = true;  // false: cut at settle_max_us, the point is flagged unsettled
};

constexpr Settling settling_of(const tg_MeasureConfig& config, int32_t step_urad) {
  const uint64_t step = static_cast<uint64_t>(step_urad < 0 ? -int64_t{step_urad} : int64_t{step_urad});
  const uint64_t us = config.settle_base_us + config.settle_per_mrad_us * step / 1000;
  if (us > config.settle_max_us) return {config.settle_max_us, false};
  return {static_cast<uint32_t>(us), true};
}

}  // namespace tetragauge
