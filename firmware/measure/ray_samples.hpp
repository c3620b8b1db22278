// SPDX-License-Identifier: Apache-2.0
// The samples of one ray, summed up as they come: laser off, on, off again.
#pragma once

#include "firmware/hal/board.hpp"

namespace tetragauge {

enum class Light : uint8_t { kOffBefore = 0, kOn = 1, kOffAfter = 2 };

struct RaySamples {
  static constexpr int kChannels = 8;  // x1 x2 y1 y2 of camera 0, then of camera 1

  int64_t sum[3][kChannels] = {};
  uint32_t count[3] = {};
  uint32_t on_rail[3] = {};  // bit for each channel that touched its rail

  void add(Light light, const PsdSample& sample, int32_t rail_codes) {
    const int phase = static_cast<int>(light);
    for (int c = 0; c < kChannels; ++c) {
      const PsdSample::Camera& camera = sample.camera[c / 4];
      const int16_t codes[4] = {camera.x1, camera.x2, camera.y1, camera.y2};
      const int32_t code = codes[c % 4];
      sum[phase][c] += code;
      if (code >= rail_codes || code <= -rail_codes) on_rail[phase] |= 1u << c;
    }
    ++count[phase];
  }
};

}  // namespace tetragauge
