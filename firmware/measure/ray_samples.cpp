// SPDX-License-Identifier: Apache-2.0
#include "firmware/measure/ray_samples.hpp"

namespace tetragauge {
namespace {

int16_t code_of(const PsdSample& sample, int channel) {
  const PsdSample::Camera& camera = sample.camera[channel / 4];
  switch (channel % 4) {
    case 0:
      return camera.x1;
    case 1:
      return camera.x2;
    case 2:
      return camera.y1;
    default:
      return camera.y2;
  }
}

// The smallest few of a sequence; the largest with the sign turned.
class Smallest {
 public:
  explicit Smallest(uint32_t wanted) : wanted_(wanted) {}
  void add(int32_t value) {
    if (kept_ == wanted_) {
      if (value >= kept_values_[kept_ - 1]) return;
      sum_ -= kept_values_[--kept_];
    }
    uint32_t at = kept_++;
    for (; at > 0 && kept_values_[at - 1] > value; --at) kept_values_[at] = kept_values_[at - 1];
    kept_values_[at] = value;
    sum_ += value;
  }
  int32_t sum() const { return sum_; }

 private:
  uint32_t wanted_, kept_ = 0;
  int32_t sum_ = 0;
  int32_t kept_values_[kBurstSamples / 4];
};

}  // namespace

// (2 a z^2 + integral of x^2 over -z .. z) / (1 - 2 a)^2 with a the share dropped at either end and z its
// quantile (Tukey 1960, "A survey of sampling from contaminated distributions"), at a = 0, 0.05 .. 0.25;
// linear between.
uint32_t trimmed_variance_permille(uint32_t dropped, uint32_t count) {
  static constexpr uint32_t kFactor[] = {1000, 1026, 1060, 1100, 1145, 1195, 1195};
  const uint32_t share = dropped * 20'000 / count;  // thousandths of 0.05
  const uint32_t at = share / 1000 < 5 ? share / 1000 : 5;
  return kFactor[at] + (kFactor[at + 1] - kFactor[at]) * (share - at * 1000) / 1000;
}

void RaySamples::add(Light light, const PsdSample* burst, uint32_t count, int32_t rail_codes,
                     uint32_t trim_permille) {
  const int phase = index(light);
  const uint32_t dropped = count * trim_permille / 1000;
  for (int c = 0; c < kChannels; ++c) {
    int32_t sum = 0;
    if (dropped == 0) {
      for (uint32_t i = 0; i < count; ++i) sum += code_of(burst[i], c);
    } else {
      Smallest low(dropped), high(dropped);
      for (uint32_t i = 0; i < count; ++i) {
        const int32_t code = code_of(burst[i], c);
        sum += code;
        low.add(code);
        high.add(-code);
      }
      sum += high.sum() - low.sum();
    }
    for (uint32_t i = 0; i < count; ++i) {
      const int32_t code = code_of(burst[i], c);
      if (code >= rail_codes || code <= -rail_codes) on_rail_[phase] |= 1u << c;
    }
    sum_[phase][c] += int64_t{sum} * 65'536 * count / (count - 2 * dropped);
  }
  count_[phase] += count;
  noise_permille_[phase] += count * trimmed_variance_permille(dropped, count);
}

// Never in double, which the processor does not have: 24 of these are asked for at each ray. Two roundings of
// float are under a thousandth of a code.
float RaySamples::mean(Light light, int channel) const {
  const uint32_t n = count(light);
  if (n == 0) return 0;
  return static_cast<float>(sum_[index(light)][channel]) / static_cast<float>(n) * 0x1p-16f;
}

float RaySamples::noise(Light light) const {
  const float n = static_cast<float>(count(light));
  return static_cast<float>(noise_permille_[index(light)]) / 1000 / (n * n);
}

}  // namespace tetragauge
