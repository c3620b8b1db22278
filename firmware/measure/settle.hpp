// SPDX-License-Identifier: Apache-2.0
// How long the mirrors need after a step. A galvanometer's settling time is nearly constant for small steps
// and grows with the step for large ones, where its drive limits the speed: base + per_mrad * step. After
// that, if the configuration asks for it, the detectors themselves say when the spot stands still.
#pragma once

#include <cstdint>

#include "firmware/hal/board.hpp"
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

inline constexpr uint32_t kStableSamples = 16;  // of each burst that is compared

// Compares the position signals, x2 - x1 and y2 - y1, of successive bursts with the laser on.
class SpotStability {
 public:
  void start(uint64_t now_ns) {
    since_ns_ = now_ns;
    bursts_ = 0;
  }
  uint64_t since_ns() const { return since_ns_; }

  // True when no camera's signal has changed by stable_codes since the burst before.
  bool add(const PsdSample* burst, uint32_t count, uint32_t stable_codes) {
    int32_t now[4] = {};
    for (uint32_t i = 0; i < count; ++i) {
      for (int c = 0; c < 2; ++c) {
        now[2 * c] += burst[i].camera[c].x2 - burst[i].camera[c].x1;
        now[2 * c + 1] += burst[i].camera[c].y2 - burst[i].camera[c].y1;
      }
    }
    bool stable = bursts_++ > 0;
    for (int k = 0; k < 4; ++k) {
      const int64_t change = int64_t{now[k]} - last_[k];
      if ((change < 0 ? -change : change) >= int64_t{stable_codes} * count) stable = false;
      last_[k] = now[k];
    }
    return stable;
  }

 private:
  uint64_t since_ns_ = 0;
  uint32_t bursts_ = 0;
  int32_t last_[4] = {};
};

}  // namespace tetragauge
