// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "firmware/measure/ray_samples.hpp"
#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

// ---------------------------------------------------------------- averaging

TEST(RaySamples, VarianceOfATrimmedMeanIsThatOfRepeatedDraws) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0, 1.5);
  for (const uint32_t trim : {0u, 50u, 100u, 250u}) {
    for (const uint32_t count : {4u, 10u, 20u, 64u, 100u}) {
      double sum = 0, sum2 = 0, said = 0;
      const int trials = 3'000, draws = trials * RaySamples::kChannels;
      const double truth = 1'000.3;
      for (int trial = 0; trial < trials; ++trial) {
        RaySamples samples;
        for (uint32_t done = 0; done < count;) {
          PsdSample burst[kBurstSamples];
          const uint32_t n = std::min(kBurstSamples, count - done);
          for (uint32_t i = 0; i < n; ++i) {
            for (auto& camera : burst[i].camera) {
              for (int16_t* code : {&camera.x1, &camera.x2, &camera.y1, &camera.y2}) {
                *code = static_cast<int16_t>(std::lround(truth + noise(random)));
              }
            }
          }
          samples.add(Light::kOn, burst, n, 32'700, trim);
          done += n;
        }
        for (int c = 0; c < RaySamples::kChannels; ++c) {
          const double error = static_cast<double>(samples.mean(Light::kOn, c)) - truth;
          sum += error;
          sum2 += error * error;
        }
        said = static_cast<double>(samples.noise(Light::kOn));
      }
      const double variance = sum2 / draws, one_sample = 1.5 * 1.5 + 1.0 / 12;
      // 24,000 draws know a variance to 0.9 %, a mean to a 150th of its sigma; float keeps 6e-5 codes here.
      EXPECT_NEAR(variance / (said * one_sample), 1, 0.04) << count << " samples, trim " << trim;
      EXPECT_NEAR(sum / draws, 0, 4 * std::sqrt(variance / draws) + 1e-4)
          << count << " samples, trim " << trim;
    }
  }
}

// Every length and share, codes from rail to rail and codes with many equal ones, in order and not.
TEST(RaySamples, MeanIsThatOfTheMiddleOfTheSortedCodes) {
  std::mt19937 random(5);
  for (uint32_t count = 1; count <= kBurstSamples; ++count) {
    for (const uint32_t trim : {0u, 20u, 100u, 150u, 250u}) {
      std::vector<int32_t> codes[RaySamples::kChannels];
      PsdSample burst[kBurstSamples] = {};
      for (int c = 0; c < RaySamples::kChannels; ++c) {
        const int32_t half_range = c < 4 ? 32'767 : 2 + c;
        std::uniform_int_distribution<int32_t> code(-half_range - 1, half_range);
        for (uint32_t i = 0; i < count; ++i) codes[c].push_back(code(random));
        if (c % 4 == 1) std::sort(codes[c].begin(), codes[c].end());
        if (c % 4 == 2) std::sort(codes[c].rbegin(), codes[c].rend());
        for (uint32_t i = 0; i < count; ++i) {
          auto& camera = burst[i].camera[c / 4];
          int16_t* const of_camera[] = {&camera.x1, &camera.x2, &camera.y1, &camera.y2};
          *of_camera[c % 4] = static_cast<int16_t>(codes[c][i]);
        }
      }
      RaySamples samples;
      samples.add(Light::kOn, burst, count, 30'000, trim);
      for (int c = 0; c < RaySamples::kChannels; ++c) {
        std::sort(codes[c].begin(), codes[c].end());
        const auto dropped = static_cast<std::ptrdiff_t>(count * trim / 1000);
        const double sum = std::accumulate(codes[c].begin() + dropped, codes[c].end() - dropped, 0.0);
        const double mean = sum / (static_cast<double>(count) - 2 * static_cast<double>(dropped));
        // A 65,536th of a code, and two roundings of float.
        EXPECT_NEAR(static_cast<double>(samples.mean(Light::kOn, c)), mean,
                    0x1p-16 + std::abs(mean) * 0x1p-22)
            << count << " samples, trim " << trim << ", channel " << c;
        const bool on_rail = codes[c].back() >= 30'000 || codes[c].front() <= -30'000;
        EXPECT_EQ(samples.on_rail(Light::kOn) >> c & 1, on_rail ? 1u : 0u);
      }
    }
  }
}

TEST(RaySamples, SpikesAreTrimmedOff) {
  PsdSample burst[40] = {};
  for (int i = 0; i < 40; ++i) burst[i].camera[1].y2 = static_cast<int16_t>(500 + i % 3);
  burst[7].camera[1].y2 = 30'000;
  burst[31].camera[1].y2 = -20'000;
  burst[32].camera[1].y2 = 9'000;
  RaySamples trimmed, plain;
  trimmed.add(Light::kOn, burst, 40, 32'700, 100);
  plain.add(Light::kOn, burst, 40, 32'700, 0);
  EXPECT_NEAR(static_cast<double>(trimmed.mean(Light::kOn, 7)), 501, 0.2);
  EXPECT_GT(static_cast<double>(plain.mean(Light::kOn, 7)), 900);
  EXPECT_EQ(trimmed.on_rail(Light::kOn), 0u);
  burst[3].camera[0].x2 = 32'700;
  trimmed.add(Light::kOffAfter, burst, 40, 32'700, 100);
  EXPECT_EQ(trimmed.on_rail(Light::kOffAfter), 2u) << "trimmed or not, a rail is a rail";
}

// ---------------------------------------------------------------- the whole machine before a plate, and what
// may go wrong

class Measure : public testing::Test {
 protected:
  void SetUp() override {
    host.connect();
    ASSERT_TRUE(host.home()) << host.trouble();
  }
  void configure(const std::function<void(tg_MeasureConfig&)>& change) {
    MachineConfig config = nominal_config();
    change(config.measure);
    tg_HostMessage set = tg_HostMessage_init_zero;
    set.which_body = tg_HostMessage_set_config_tag;
    ASSERT_TRUE(get_part(config, tg_ConfigPart_CONFIG_MEASURE, &set.body.set_config));
    ASSERT_EQ(host.ask(set).which_body, tg_MachineMessage_done_tag);
  }
  void scan(const tg_View& view) {
    ASSERT_TRUE(host.scan({view}));
    ASSERT_TRUE(host.run_until([&] { return host.ended; }, 60)) << host.trouble();
    ASSERT_EQ(host.beams.size(), kSmallViewRays) << "every beam is there, with or without a point";
    EXPECT_EQ(host.end.crc, host.crc());
  }
  // Each beam rejected for this reason, with the direction it had.
  void expect_rejected(tg_RejectReason reason) {
    for (const BeamRecord& beam : host.beams) {
      ASSERT_EQ(beam.reason, static_cast<uint32_t>(reason)) << beam.ray;
      const RayTarget target = target_of(small_view(), beam.ray);
      ASSERT_NEAR(beam.a_urad, target.a_urad, kUradPerMirrorCode / 2);
      ASSERT_NEAR(beam.b_urad, target.b_urad, kUradPerMirrorCode / 2);
    }
  }
  // Each a point on the plate x = 0, with these flags. Rounding to codes: controller_test.cpp.
  void expect_points(uint32_t flags, double within_um = 11) {
    for (const BeamRecord& beam : host.beams) {
      ASSERT_EQ(beam.reason, 0u) << beam.ray;
      ASSERT_EQ(beam.flags, flags) << beam.ray;
      ASSERT_NEAR(beam.x_um, 0, within_um) << beam.ray;
      ASSERT_GT(beam.sigma_100nm, 0u);
    }
  }
  double mean_sigma_um() const {
    double sum = 0;
    for (const BeamRecord& beam : host.beams) sum += 0.1 * beam.sigma_100nm;
    return sum / static_cast<double>(host.beams.size());
  }
  TestHost host;
};

TEST_F(Measure, WeakWhenTheSurfaceIsBlack) {
  host.board.light_codes = 20;
  scan(small_view());
  expect_rejected(tg_RejectReason_REJECT_WEAK);
}

TEST_F(Measure, WeakWhenBothCamerasAreCovered) {
  host.board.covered[0] = host.board.covered[1] = true;
  scan(small_view());
  expect_rejected(tg_RejectReason_REJECT_WEAK);
}

TEST_F(Measure, SaturatedByAMirrorLikeSurface) {
  host.board.light_codes = 70'000;
  scan(small_view());
  expect_rejected(tg_RejectReason_REJECT_SATURATED);
}

TEST_F(Measure, AmbientWhenSunlightFloodsTheCameras) {
  host.board.ambient_codes = 50'000;
  host.board.light_codes = 2'000;
  scan(small_view());
  expect_rejected(tg_RejectReason_REJECT_AMBIENT);
}

TEST_F(Measure, AmbientWhenALampIsSwitchedOnInTheMiddleOfARay) {
  // Off, on, off: the lamp comes with the laser and stays for the rest of the ray.
  host.board.when_laser_goes_on = [&] { host.board.ambient_codes = 5'000; };
  host.after_every_event = [&] {
    if (host.board.mirrors_set_ns == host.board.now) host.board.ambient_codes = 100;
  };
  scan(small_view());
  expect_rejected(tg_RejectReason_REJECT_AMBIENT);
}

TEST_F(Measure, SteadyAmbientLightCancels) {
  host.board.ambient_codes = 8'000;
  scan(small_view());
  expect_points(0);
}

TEST_F(Measure, InconsistentWhenOneCameraSeesAnotherSpot) {
  host.board.camera_1_shift_mm = 0.5;  // a second reflection, 5 mm beside the first
  scan(small_view());
  expect_rejected(tg_RejectReason_REJECT_INCONSISTENT);
}

TEST_F(Measure, InconsistentWhenTheBeamIsNotWhereTheMirrorsWereSent) {
  host.board.mirror_lag_rad = [](uint64_t) { return 0.004; };  // a stuck mirror: 2.8 mm aside at the spot
  scan(small_view());
  expect_rejected(tg_RejectReason_REJECT_INCONSISTENT);
}

TEST_F(Measure, OutsideTheVolumeWhenTheBeamMissesThePart) {
  host.board.plate_x_mm = -80;
  scan(small_view());
  expect_rejected(tg_RejectReason_REJECT_OUTSIDE_VOLUME);
}

TEST_F(Measure, OneCameraIsEnoughForALessExactPoint) {
  scan(small_view());
  expect_points(0);
  const double with_two = mean_sigma_um(), kAngle = std::acos(-1.0) / 8;
  for (const int hidden : {0, 1}) {
    host.board.covered[hidden] = true;
    scan(small_view());
    expect_points(tg_PointFlag_POINT_ONE_CAMERA, 22);
    // Cameras at 22.5 degrees on either side of the beam, a standard deviation of c across each camera's ray
    // and of b = 16 urad * 350 mm across the beam: along the beam c / (sqrt 2 sin) with two, sqrt(c^2 + b^2
    // cos^2) / sin with one, which takes the beam's own error for the spot's.
    const double c = with_two * std::sqrt(2.0) * std::sin(kAngle), b = 5.6;
    EXPECT_NEAR(mean_sigma_um(), std::hypot(c, b * std::cos(kAngle)) / std::sin(kAngle), 0.03 * with_two);
    host.board.covered[hidden] = false;
  }
}

TEST_F(Measure, LittleLightIsFlaggedAndLessExact) {
  scan(small_view());
  const double bright = mean_sigma_um();
  host.board.light_codes = 200;
  scan(small_view());
  expect_points(tg_PointFlag_POINT_WEAK, 1'600);
  EXPECT_GT(mean_sigma_um(), 2 * bright);
}

TEST_F(Measure, AStepTooLargeForTheTimeAllowedIsFlagged) {
  configure([](tg_MeasureConfig& measure) { measure.settle_max_us = measure.settle_base_us + 50; });
  scan(small_view());
  // 3 mrad a step need 120 us more than the base: every ray but none that stands where the mirrors were.
  expect_points(tg_PointFlag_POINT_UNSETTLED);
}

// A mirror that creeps: 0.3 mrad off after the modelled settling, with a time constant of 1 ms.
double creep(uint64_t since_set_ns) {
  return 3e-4 * std::exp(-1e-6 * static_cast<double>(since_set_ns));
}

TEST_F(Measure, WaitsUntilTheSpotStandsStill) {
  // With one camera the beam's place is taken at its word, so it had better be there.
  host.board.covered[1] = true;
  host.board.mirror_lag_rad = creep;
  scan(small_view());
  double worst_um = 0;
  for (const BeamRecord& beam : host.beams) worst_um = std::max(worst_um, std::abs(0.0 + beam.x_um));
  EXPECT_GT(worst_um, 100) << "by time alone the creep is in the points, unseen";

  // One code of the position signal is 0.33 um on the detector, 3.6 um at the spot. A creep of time constant
  // 1 ms that moves it by that much from burst to burst, 0.16 ms, has 23 um to go: 56 um along the beam with
  // one camera.
  configure([](tg_MeasureConfig& measure) {
    measure.stable_codes = 1;
    measure.stable_max_us = 20'000;
  });
  scan(small_view());
  expect_points(tg_PointFlag_POINT_ONE_CAMERA, 60);
}

TEST_F(Measure, GivesUpWaitingAndSaysSo) {
  // It drifts on by 0.12 rad/s for ever: 4 codes from burst to burst.
  host.board.mirror_lag_rad = [&](uint64_t since) { return 0.12e-9 * static_cast<double>(since); };
  configure([](tg_MeasureConfig& measure) {
    measure.stable_codes = 3;
    measure.stable_max_us = 500;
  });
  scan(small_view());
  for (const BeamRecord& beam : host.beams) {
    EXPECT_EQ(beam.reason, 0u);
    EXPECT_EQ(beam.flags, static_cast<uint32_t>(tg_PointFlag_POINT_UNSETTLED));
  }
}

TEST_F(Measure, SpikesOnTheWiresDoNotMoveThePoint) {
  std::mt19937 random(3);
  host.board.spoil_sample = [&](PsdSample& sample) {
    if (random() % 25 == 0) sample.camera[random() % 2].x1 = static_cast<int16_t>(random() % 30'000);
  };
  tg_View view = small_view();
  view.samples = 64;
  configure([](tg_MeasureConfig& measure) { measure.trim_permille = 150; });
  scan(view);
  expect_points(0, 15);
  configure([](tg_MeasureConfig& measure) { measure.trim_permille = 0; });
  scan(view);
  double worst_um = 0;
  for (const BeamRecord& beam : host.beams) worst_um = std::max(worst_um, std::abs(0.0 + beam.x_um));
  EXPECT_GT(worst_um, 100) << "the same spikes without trimming";
}

}  // namespace
}  // namespace tetragauge
