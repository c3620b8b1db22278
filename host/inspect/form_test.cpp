// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/form.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tetragauge {
namespace {

struct Points {
  std::vector<Vec3> place;
  std::vector<double> residual;
};

Points noisy(size_t n, double sigma, double bump_mm, std::mt19937_64& random) {
  std::uniform_real_distribution<double> along(0, 50);
  std::normal_distribution<double> normal;
  Points points;
  for (size_t k = 0; k < n; ++k) {
    points.place.emplace_back(along(random), along(random), 0);
    const bool inside =
        points.place.back().x() > 10 && points.place.back().x() < 30 && points.place.back().y() < 25;
    points.residual.push_back(sigma * normal(random) + (inside ? bump_mm : 0.0));
  }
  return points;
}

TEST(Form, ExpectedRangeOfNormalValues) {
  // Tippett, Biometrika 17 (1925) 364, the table behind every control chart's d2.
  EXPECT_NEAR(expected_range(2), 1.128, 0.06);
  EXPECT_NEAR(expected_range(5), 2.326, 0.06);
  EXPECT_NEAR(expected_range(10), 3.078, 0.03);
  EXPECT_NEAR(expected_range(100), 5.015, 0.03);
  EXPECT_NEAR(expected_range(1000), 6.483, 0.03);
}

TEST(Form, NoiseIsNotForm) {
  // Raw peak to valley of 1,000 points is 6.5 sigma = 0.13 mm; the face is flat.
  std::mt19937_64 random(1);
  int within = 0;
  for (int n = 0; n < 200; ++n) {
    const Points p = noisy(1000, 0.02, 0, random);
    const Form form = form_deviation(p.place, p.residual, 2500, 0.1);
    EXPECT_LT(form.form_mm, 0.03);
    EXPECT_GT(form.cells, 10u);
    within += form.form_mm <= form.U_mm;
  }
  EXPECT_GE(within, 184);  // 95 % of 200, less two standard deviations
}

TEST(Form, ARaisedAreaIsFound) {
  std::mt19937_64 random(2);
  int within = 0;
  for (int n = 0; n < 100; ++n) {
    const Points p = noisy(3000, 0.02, 0.08, random);
    const Form form = form_deviation(p.place, p.residual, 2500, 0.1);
    within += std::abs(form.form_mm - 0.08) < form.U_mm;
  }
  EXPECT_GE(within, 91);  // 95 % of 100, less two standard deviations
}

TEST(Form, FewPointsHaveNoForm) {
  EXPECT_EQ(form_deviation({}, {}, 0, 0.1).form_mm, 0);
  std::mt19937_64 random(3);
  const Points p = noisy(5, 0.02, 0, random);
  EXPECT_EQ(form_deviation(p.place, p.residual, 2500, 0.1).form_mm, 0);
}

}  // namespace
}  // namespace tetragauge
