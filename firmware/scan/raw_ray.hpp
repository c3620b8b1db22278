// SPDX-License-Identifier: Apache-2.0
// Every sample of one ray, for views that ask for them (View.raw), and their way out in messages.
//
//   raw.start(samples);  raw.add(burst, count);  ...    // off before, on, off after, as they come
//   while (raw.left() > 0) raw.take(&message);          // up to 16 samples of one phase each
#pragma once

#include "firmware/hal/board.hpp"
#include "protocol/machine.pb.h"

namespace tetragauge {

template <uint32_t kMaxOn>
class RawRay {
 public:
  // `on` samples with the laser on, half as many before and after.
  void start(uint32_t on) {
    on_ = on;
    count_ = taken_ = 0;
  }
  void add(const PsdSample* burst, uint32_t count) {
    for (uint32_t i = 0; i < count && count_ < 2 * kMaxOn; ++i) samples_[count_++] = burst[i];
  }
  uint32_t left() const { return count_ - taken_; }

  // The next ones; plan, view and ray are the caller's.
  void take(tg_RawSamples* message) {
    const uint32_t begin[4] = {0, on_ / 2, on_ / 2 + on_, 2 * on_};
    uint32_t phase = 0;
    while (taken_ >= begin[phase + 1]) ++phase;
    message->phase = phase;
    message->first_sample = taken_ - begin[phase];
    message->codes_count = 0;
    int32_t last[8] = {};
    for (uint32_t k = 0; k < kSamplesPerItem && taken_ < begin[phase + 1] && taken_ < count_; ++k, ++taken_) {
      for (int c = 0; c < 8; ++c) {
        const PsdSample::Camera& camera = samples_[taken_].camera[c / 4];
        const int16_t codes[4] = {camera.x1, camera.x2, camera.y1, camera.y2};
        message->codes[message->codes_count++] = codes[c % 4] - last[c];
        last[c] = codes[c % 4];
      }
    }
  }

 private:
  static constexpr uint32_t kSamplesPerItem = sizeof(tg_RawSamples::codes) / sizeof(int32_t) / 8;

  uint32_t on_ = 0, count_ = 0, taken_ = 0;
  PsdSample samples_[2 * kMaxOn] = {};
};

}  // namespace tetragauge
