// SPDX-License-Identifier: GPL-3.0-or-later
// Judged by drawing the corners' noise many times, and by a tetrahedron whose volume is a formula.
#include "host/measure/volume_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tetragauge {
namespace {

double volume_mm3(const std::array<Vec3, 4>& v) {
  return (v[1] - v[0]).cross(v[2] - v[0]).dot(v[3] - v[0]) / 6;
}

TEST(VolumeNoise, AgreesWithDrawnCorners) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> gauss;
  const auto vector = [&]() -> Vec3 { return {gauss(random), gauss(random), gauss(random)}; };
  for (int shape = 0; shape < 10; ++shape) {
    std::array<NoisyCorner, 4> corners;
    for (NoisyCorner& corner : corners)
      corner = {5 * vector(), vector().normalized(), 0.01 * std::abs(gauss(random))};
    if (shape % 2 == 0) corners[0].ray.setZero();
    constexpr int kDraws = 20'000;
    double sum = 0, sum2 = 0;
    for (int k = 0; k < kDraws; ++k) {
      std::array<Vec3, 4> drawn;
      for (size_t i = 0; i < 4; ++i)
        drawn[i] = corners[i].at_mm + corners[i].sigma_mm * gauss(random) * corners[i].ray;
      const double v = volume_mm3(drawn);
      sum += v;
      sum2 += v * v;
    }
    const double mean = sum / kDraws, drawn_sigma = std::sqrt(sum2 / kDraws - mean * mean);
    // So many draws know a standard deviation to 0.5 %; the second order is as small here.
    EXPECT_NEAR(volume_sigma_mm3(corners) / drawn_sigma, 1, 0.03) << shape;
  }
}

TEST(VolumeNoise, OfAHeightIsThatHeightsShare) {
  // V = A h / 3, only h is uncertain; along the facet nothing changes.
  std::array<NoisyCorner, 4> corners;
  corners[1].at_mm = {4, 0, 0};
  corners[2].at_mm = {0, 3, 0};
  corners[3] = {Vec3(1, 1, 2), Vec3(0, 0, -1), 0.1};
  EXPECT_NEAR(volume_sigma_mm3(corners), 6 * 0.1 / 3, 1e-12);
  corners[3].ray = Vec3::UnitX();
  EXPECT_NEAR(volume_sigma_mm3(corners), 0, 1e-12);
}

}  // namespace
}  // namespace tetragauge
