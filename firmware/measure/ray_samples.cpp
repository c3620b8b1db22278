// SPDX-License-Identifier: Apache-2.0
#include "firmware/measure/ray_samples.hpp"

#include <cstddef>
#include <cstring>

namespace tetragauge {
namespace {

// A channel is every eighth code of a burst.
static_assert(sizeof(PsdSample) == RaySamples::kChannels * sizeof(int16_t));
int32_t code_at(const std::byte* channel, uint32_t sample) {
  int16_t code;
  std::memcpy(&code, channel + sample * sizeof(PsdSample), sizeof code);
  return code;
}

struct Extremes {
  int32_t smallest = 0, largest = 0;
  int32_t sum = 0;  // of what is not dropped
};

Extremes sum_up(const std::byte* channel, uint32_t count) {
  Extremes all;
  all.smallest = all.largest = all.sum = code_at(channel, 0);
  for (uint32_t i = 1; i < count; ++i) {
    const int32_t code = code_at(channel, i);
    all.sum += code;
    if (code < all.smallest) all.smallest = code;
    if (code > all.largest) all.largest = code;
  }
  return all;
}

// The smallest `dropped` and the largest in order, both from the outside in. Most codes lie between the two
// innermost ones, and cost two comparisons.
constexpr uint32_t kMostDropped = kBurstSamples / 4;
struct Kept {
  int32_t smallest[kMostDropped], largest[kMostDropped];
};

// `at`: where a code that is further out than the innermost one may go, from the inside out.
void put_small(int32_t code, int32_t* at, const int32_t* outermost) {
  for (; at != outermost && at[-1] > code; --at) *at = at[-1];
  *at = code;
}
void put_large(int32_t code, int32_t* at, const int32_t* outermost) {
  for (; at != outermost && at[-1] < code; --at) *at = at[-1];
  *at = code;
}

Extremes sum_up_trimmed(const std::byte* channel, uint32_t count, uint32_t dropped) {
  Kept kept;
  Extremes all;
  for (uint32_t i = 0; i < dropped; ++i) {
    const int32_t code = code_at(channel, i);
    all.sum += code;
    put_small(code, kept.smallest + i, kept.smallest);
    put_large(code, kept.largest + i, kept.largest);
  }
  int32_t* const inner_small = kept.smallest + dropped - 1;
  int32_t* const inner_large = kept.largest + dropped - 1;
  int32_t low = *inner_small, high = *inner_large;
  for (uint32_t i = dropped; i < count; ++i) {
    const int32_t code = code_at(channel, i);
    all.sum += code;
    if (code < low) {
      put_small(code, inner_small, kept.smallest);
      low = *inner_small;
    }
    if (code > high) {
      put_large(code, inner_large, kept.largest);
      high = *inner_large;
    }
  }
  for (uint32_t k = 0; k < dropped; ++k) all.sum -= kept.smallest[k] + kept.largest[k];
  all.smallest = kept.smallest[0];
  all.largest = kept.largest[0];
  return all;
}

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
  const auto kept = static_cast<int32_t>(count - 2 * dropped);
  for (int c = 0; c < kChannels; ++c) {
    const std::byte* channel =
        reinterpret_cast<const std::byte*>(burst) + static_cast<size_t>(c) * sizeof(int16_t);
    const Extremes all = dropped == 0 ? sum_up(channel, count) : sum_up_trimmed(channel, count, dropped);
    if (all.largest >= rail_codes || all.smallest <= -rail_codes) on_rail_[phase] |= 1u << c;
    // sum * 2^16 * count / kept without a division of 64 bits, of which the processor has none: a sum is less
    // than 2^15 * 2^6, so all of these keep to 32 bits.
    const int32_t weighted = all.sum * static_cast<int32_t>(count);
    const int32_t whole = weighted / kept, rest = weighted % kept;
    sum_[phase][c] += int64_t{whole} * 65'536 + rest * 65'536 / kept;
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
