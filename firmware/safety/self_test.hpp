// SPDX-License-Identifier: Apache-2.0
// What the machine can check of itself with the laser off and the stage at rest, in 250 ms at most: inputs,
// step timers, converter and detectors in the dark, store, and what the board adds.
//
//   self_test.start(config);
//   poll() and the interrupts until !running(); then reply().
#pragma once

#include "firmware/hal/board.hpp"
#include "firmware/machine_config.hpp"
#include "firmware/storage/calibration_store.hpp"

namespace tetragauge {

template <Board B>
class SelfTest {
 public:
  // `burst` has room for kBurstSamples; it is used from the poll() on that finds the converter free.
  SelfTest(B& board, const CalibrationStore& store, PsdSample* burst)
      : board_(board), store_(store), burst_(burst) {}

  // Axes at rest.
  void start(const MachineConfig& config) {
    config_ = &config;
    reply_ = tg_SelfTestReply_init_zero;
    bursts_done_ = 0;
    longest_burst_ns_ = 0;
    for (Channel& channel : channels_) channel = {};
    end_ns_ = board_.now_ns() + kLongestNs;
    running_ = true;
    step_due_ = board_.step_clock() + kStepAfterTicks;
    for (int k = 0; k < kAxes; ++k) {
      step_pending_[k] = true;
      step_late_ns_[k] = 0;
      board_.schedule_step(static_cast<Axis>(k), step_due_, 0);
    }
  }

  bool running() const { return running_; }
  // Its burst is under way: the next on_samples is for the self-test.
  bool sampling() const { return burst_running_; }
  const tg_SelfTestReply& reply() const { return reply_; }
  uint64_t next_poll_ns() const { return running_ ? end_ns_ : ~uint64_t{0}; }

  // `converter_free`: a scan's last burst is over.
  void poll(bool converter_free) {
    if (!running_) return;
    if (!burst_running_ && converter_free && bursts_done_ < kBursts) {
      burst_running_ = true;
      burst_start_ns_ = board_.now_ns();
      board_.start_samples(burst_, kBurstSamples);
    }
    const bool all_came = bursts_done_ == kBursts && !step_pending_[0] && !step_pending_[1];
    if (all_came || board_.now_ns() >= end_ns_) judge();
  }

  void on_samples() {
    burst_running_ = false;
    const uint64_t took_ns = board_.now_ns() - burst_start_ns_;
    if (took_ns > longest_burst_ns_) longest_burst_ns_ = took_ns;
    for (uint32_t i = 0; i < kBurstSamples; ++i) {
      for (int c = 0; c < 2; ++c) {
        const PsdSample::Camera& camera = burst_[i].camera[c];
        const int16_t codes[4] = {camera.x1, camera.x2, camera.y1, camera.y2};
        for (int k = 0; k < 4; ++k) channels_[4 * c + k].add(codes[k]);
      }
    }
    bursts_done_ = bursts_done_ + 1;
  }

  void on_step_timer(Axis axis) {
    const int k = static_cast<int>(axis);
    if (!running_ || !step_pending_[k]) return;
    step_pending_[k] = false;
    step_late_ns_[k] = (board_.step_clock() - step_due_) * 1'000'000'000 / B::kStepTicksPerSecond;
  }

 private:
  static constexpr uint64_t kLongestNs = 250'000'000;
  static constexpr uint64_t kStepAfterTicks = B::kStepTicksPerSecond / 1000;
  // Half the spacing of steps at 200 kHz: later ones would bunch.
  static constexpr int32_t kStepLateNs = 2'500;
  // As many as fit 150 ms, and 8 at most: 512 samples give a variance to 6 %.
  static constexpr uint64_t kBurstNs = uint64_t{kBurstSamples} * B::kSamplePeriodNs;
  static constexpr uint32_t kBursts = kBurstNs >= 150'000'000 ? 1
                                      : 150'000'000 / kBurstNs > 8
                                          ? 8
                                          : static_cast<uint32_t>(150'000'000 / kBurstNs);
  // A variance known to 6 % that is twice the expected one is no accident.
  static constexpr int kNoiseMargin = 2;

  struct Channel {
    int64_t sum = 0, squares = 0;
    void add(int32_t code) {
      sum += code;
      squares += int64_t{code} * code;
    }
  };

  static int32_t clipped(int64_t x) { return x > INT32_MAX ? INT32_MAX : static_cast<int32_t>(x); }

  void add(tg_SelfTestCheck check, tg_SelfTestResult result, int64_t value, int64_t limit) {
    reply_.items[reply_.items_count++] = {check, result, clipped(value), clipped(limit)};
  }
  void at_least(tg_SelfTestCheck check, int64_t value, int64_t limit) {
    add(check, value >= limit ? tg_SelfTestResult_SELF_TEST_PASSED : tg_SelfTestResult_SELF_TEST_FAILED,
        value, limit);
  }
  void at_most(tg_SelfTestCheck check, int64_t value, int64_t limit) {
    add(check, value <= limit ? tg_SelfTestResult_SELF_TEST_PASSED : tg_SelfTestResult_SELF_TEST_FAILED,
        value, limit);
  }
  void of_board(tg_SelfTestCheck check) {
    tg_SelfTestItem& item = reply_.items[reply_.items_count++];
    item = tg_SelfTestItem_init_zero;
    if (!board_.self_check(check, &item)) item.result = tg_SelfTestResult_SELF_TEST_ABSENT;
    item.check = check;
  }

  void judge() {
    running_ = false;
    const uint32_t inputs = board_.inputs();
    at_least(tg_SelfTestCheck_CHECK_INTERLOCK, (inputs & Inputs::kInterlockClosed) != 0, 1);
    at_least(tg_SelfTestCheck_CHECK_MIRRORS, (inputs & Inputs::kMirrorsGood) != 0, 1);
    at_least(tg_SelfTestCheck_CHECK_LASER_DRIVER, (inputs & Inputs::kLaserGood) != 0, 1);
    // A burst that never came counts as long as it was waited for.
    if (burst_running_) longest_burst_ns_ = board_.now_ns() - burst_start_ns_;
    burst_running_ = false;
    const bool sampled = bursts_done_ == kBursts;
    const auto per_sample = static_cast<int64_t>(longest_burst_ns_ / kBurstSamples);
    const int64_t longest_sample = int64_t{B::kSamplePeriodNs} * 3 / 2;
    add(tg_SelfTestCheck_CHECK_CONVERTER,
        sampled && per_sample <= longest_sample ? tg_SelfTestResult_SELF_TEST_PASSED
                                                : tg_SelfTestResult_SELF_TEST_FAILED,
        per_sample, longest_sample);
    judge_detectors(sampled);
    if (store_.present()) {
      at_least(tg_SelfTestCheck_CHECK_STORE, store_.valid_copies(),
               store_.ever_written() ? int64_t{Storage::kBanks} : 0);
    } else {
      add(tg_SelfTestCheck_CHECK_STORE, tg_SelfTestResult_SELF_TEST_ABSENT, 0, 0);
    }
    uint64_t late = 0;
    for (int k = 0; k < kAxes; ++k) {
      if (step_pending_[k]) step_late_ns_[k] = board_.now_ns() - step_due_;
      if (step_late_ns_[k] > late) late = step_late_ns_[k];
      step_pending_[k] = false;
    }
    at_most(tg_SelfTestCheck_CHECK_STEP_TIMERS, static_cast<int64_t>(late), kStepLateNs);
    of_board(tg_SelfTestCheck_CHECK_CLOCK);
    of_board(tg_SelfTestCheck_CHECK_TRANSPORT);
  }

  void judge_detectors(bool sampled) {
    const int64_t count = int64_t{kBurstSamples} * bursts_done_;
    const int64_t most_dark = config_->measure.ambient_codes / 2 < config_->measure.rail_codes
                                  ? config_->measure.ambient_codes / 2
                                  : config_->measure.rail_codes;
    const tg_SelfTestCheck dark[] = {tg_SelfTestCheck_CHECK_DARK_CAMERA_1,
                                     tg_SelfTestCheck_CHECK_DARK_CAMERA_2};
    const tg_SelfTestCheck noise[] = {tg_SelfTestCheck_CHECK_NOISE_CAMERA_1,
                                      tg_SelfTestCheck_CHECK_NOISE_CAMERA_2};
    int64_t noise_value[2], noise_limit[2];
    for (int c = 0; c < 2; ++c) {
      int64_t mean = 0, variance = 0;
      for (int k = 4 * c; k < 4 * c + 4 && sampled; ++k) {
        const Channel& channel = channels_[k];
        reply_.dark_codes[reply_.dark_codes_count++] = clipped(channel.sum / count);
        const int64_t of_channel = (channel.sum < 0 ? -channel.sum : channel.sum) / count;
        if (of_channel > mean) mean = of_channel;
        // Below 2^30 * 512 * 512 * 1000 < 2^63.
        const int64_t thousandths =
            (channel.squares * count - channel.sum * channel.sum) * 1000 / (count * (count - 1));
        if (thousandths > variance) variance = thousandths;
      }
      const tg_CameraConfig& camera = config_->camera[c];
      noise_value[c] = variance;
      // A twelfth: rounding to codes.
      noise_limit[c] = static_cast<int64_t>(
          1000 * kNoiseMargin *
          (camera.dark_variance_codes2 + camera.shot_variance_codes * static_cast<double>(mean) + 1.0 / 12));
      if (sampled) {
        at_most(dark[c], mean, most_dark);
      } else {
        add(dark[c], tg_SelfTestResult_SELF_TEST_FAILED, 0, most_dark);
      }
    }
    for (int c = 0; c < 2; ++c) {
      if (sampled) {
        at_most(noise[c], noise_value[c], noise_limit[c]);
      } else {
        add(noise[c], tg_SelfTestResult_SELF_TEST_FAILED, 0, noise_limit[c]);
      }
    }
  }

  B& board_;
  const CalibrationStore& store_;
  PsdSample* const burst_;
  const MachineConfig* config_ = nullptr;
  bool running_ = false;
  uint64_t end_ns_ = 0;
  tg_SelfTestReply reply_ = tg_SelfTestReply_init_zero;

  uint64_t step_due_ = 0, step_late_ns_[kAxes] = {};
  volatile bool step_pending_[kAxes] = {};

  volatile bool burst_running_ = false;
  uint64_t burst_start_ns_ = 0, longest_burst_ns_ = 0;
  volatile uint32_t bursts_done_ = 0;
  Channel channels_[8];
};

}  // namespace tetragauge
