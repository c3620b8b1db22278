// SPDX-License-Identifier: Apache-2.0
// The samples of one ray, averaged as they come: laser off, on, off again.
//
//   samples.add(Light::kOn, burst, count, rail_codes, trim_permille);   // bursts of up to 64
//   samples.mean(Light::kOn, channel);  samples.noise(Light::kOn);
//
// The mean is trimmed: of each burst and channel the share trim_permille at either end is dropped (whole
// samples, so none of a short burst), the bursts weighted by their length. That keeps memory bounded whatever
// the number of samples, and spikes out. It costs a little noise, which noise() says: by the variance of a
// trimmed mean of normal values, n f(trim) / n^2. Codes are whole numbers: noise of less than half a
// converter step would make a trimmed mean lean towards the nearest code, so a quieter converter wants trim
// 0.
#pragma once

#include "firmware/hal/board.hpp"

namespace tetragauge {

enum class Light : uint8_t { kOffBefore = 0, kOn = 1, kOffAfter = 2 };

// Variance of a trimmed mean over that of the mean, thousandths, for the share dropped at either end.
uint32_t trimmed_variance_permille(uint32_t dropped, uint32_t count);

struct RaySamples {
  static constexpr int kChannels = 8;  // x1 x2 y1 y2 of camera 0, then of camera 1

  void add(Light light, const PsdSample* burst, uint32_t count, int32_t rail_codes, uint32_t trim_permille);

  uint32_t count(Light light) const { return count_[index(light)]; }
  // Bit for each channel that touched its rail.
  uint32_t on_rail(Light light) const { return on_rail_[index(light)]; }
  float mean(Light light, int channel) const;  // code
  // Variance of a mean over that of one sample.
  float noise(Light light) const;

 private:
  static int index(Light light) { return static_cast<int>(light); }

  int64_t sum_[3][kChannels] = {};  // of means times lengths, codes * 2^16
  uint32_t count_[3] = {};
  uint32_t noise_permille_[3] = {};  // of lengths times variance factors
  uint32_t on_rail_[3] = {};
};

}  // namespace tetragauge
