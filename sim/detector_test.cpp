// SPDX-License-Identifier: GPL-3.0-or-later
// Noise of the detectors against the hand calculation of docs/machine.md.
#include "sim/detector.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/noise.hpp"

namespace tetragauge::sim {
namespace {

struct Statistics {
  double sum = 0, sum2 = 0;
  int count = 0;
  void add(double x) {
    sum += x;
    sum2 += x * x;
    ++count;
  }
  double mean() const { return sum / count; }
  double deviation() const { return std::sqrt(sum2 / count - mean() * mean()); }
};

TEST(Noise, IsNormalAndAPureFunctionOfItsKey) {
  EXPECT_EQ(normal_pair(42), normal_pair(42));
  EXPECT_NE(normal_pair(42), normal_pair(43));
  Statistics one;
  double product = 0;
  int beyond_two = 0;
  constexpr int kDraws = 100'000;
  for (uint64_t key = 0; key < kDraws; ++key) {
    const auto [a, b] = normal_pair(combine_key(7, key));
    one.add(a);
    product += a * b;
    beyond_two += std::abs(a) > 2 ? 1 : 0;
  }
  // Standard errors: 1/sqrt(n), 1/sqrt(2 n); share beyond 2 sigma 4.55 %.
  EXPECT_NEAR(one.mean(), 0, 5 / std::sqrt(kDraws));
  EXPECT_NEAR(one.deviation(), 1, 5 / std::sqrt(2.0 * kDraws));
  EXPECT_NEAR(product / kDraws, 0, 5 / std::sqrt(kDraws));
  EXPECT_NEAR(static_cast<double>(beyond_two) / kDraws, 0.0455, 5 * std::sqrt(0.0455 / kDraws));
}

TEST(DetectorElectronics, CodesCarryPositionAndCurrent) {
  Numbers quiet;
  quiet.noise_bandwidth_Hz = 0;
  quiet.converter_noise_lsb = 0;
  quiet.converter_inl_lsb = 0;
  const DetectorElectronics electronics(quiet, 0);
  // 1 uA through 1 MOhm is 1 V: 6553.6 steps of 5 V / 32768, shared 3 to 1 at half the half side.
  const DetectorCodes codes =
      electronics.sample({.current_A = 1e-6, .x = 0.5, .y = -0.5, .magnification = 0.1}, 1, 0, 0);
  EXPECT_EQ(codes.x1, 1638);
  EXPECT_EQ(codes.x2, 4915);
  EXPECT_EQ(codes.y1, 4915);
  EXPECT_EQ(codes.y2, 1638);
  const DetectorCodes dark =
      electronics.sample({.current_A = 1e-6, .x = 0.5, .y = -0.5, .magnification = 0.1}, 0, 0, 0);
  EXPECT_EQ(dark.x2, 0);
  const DetectorCodes rail =
      electronics.sample({.current_A = 1, .x = 0, .y = 0, .magnification = 0.1}, 1, 0, 0);
  EXPECT_EQ(rail.x1, 32767);
}

TEST(DetectorElectronics, TwelveBitsAreLeftAligned) {
  Numbers numbers;
  numbers.converter_bits = 12;
  const DetectorElectronics electronics(numbers, 0);
  for (uint64_t key = 0; key < 20; ++key) {
    EXPECT_EQ(
        electronics.sample({.current_A = 1e-6, .x = 0.1, .y = 0.2, .magnification = 0.1}, 1, 0.1e-6, key).x1 %
            16,
        0);
  }
}

TEST(DetectorElectronics, NonLinearityStaysWithinItsLimitAndReachesAFairShareOfIt) {
  Numbers straight, bent;
  for (Numbers* n : {&straight, &bent}) n->noise_bandwidth_Hz = n->converter_noise_lsb = 0;
  straight.converter_inl_lsb = 0;
  bent.converter_inl_lsb = 24;
  for (size_t camera = 0; camera < 2; ++camera) {
    const DetectorElectronics a(straight, camera), b(bent, camera);
    int largest = 0;
    for (double current_A = 0; current_A < 9e-6; current_A += 0.05e-6) {
      const SpotImage image{.current_A = current_A, .x = 0, .y = 0, .magnification = 0.1};
      largest = std::max(largest, std::abs(a.sample(image, 1, 0, 0).x1 - b.sample(image, 1, 0, 0).x1));
    }
    EXPECT_LE(largest, 25);
    EXPECT_GE(largest, 8);
  }
}

TEST(DetectorElectronics, NoiseIsTheHandCalculation) {
  const DetectorElectronics electronics(Numbers{}, 0);
  Statistics dark, bright;
  for (uint64_t key = 0; key < 50'000; ++key) {
    dark.add(electronics.sample({}, 0, 0.1e-6, mix_bits(key)).x1);
    bright.add(
        electronics
            .sample({.current_A = 8e-6, .x = 0, .y = 0, .magnification = 0.1}, 1, 0.1e-6, mix_bits(key))
            .x1);
  }
  // docs/machine.md: 1.49 steps without light; each micro-ampere adds 2 q I B R^2 = (0.48 steps)^2.
  EXPECT_NEAR(dark.deviation(), 1.49, 0.03);
  EXPECT_NEAR(bright.deviation(), std::sqrt(1.49 * 1.49 + 4 * 0.48 * 0.48), 0.03);
}

TEST(AddSpeckle, MovesTheSpotByTheTheorysAmount) {
  const Numbers numbers;
  const TrueCamera camera = nominal_geometry().cameras[0];
  // At the aim point the lens is 378.8 mm away: u = 8.75 / 378.9, lambda / (2 pi sin u) = 4.48 um at the
  // spot, 0.414 um on the detector.
  const double magnification = 35 / 378.8;
  Statistics x;
  for (uint64_t key = 0; key < 20'000; ++key) {
    x.add(10e3 * add_speckle(numbers, camera,
                             {.current_A = 1e-6, .x = 0, .y = 0, .magnification = magnification},
                             mix_bits(key))
                     .x);
  }
  EXPECT_NEAR(x.mean(), 0, 0.02);
  EXPECT_NEAR(x.deviation(), 0.414, 0.02);
}

}  // namespace
}  // namespace tetragauge::sim
