// SPDX-License-Identifier: GPL-3.0-or-later
// Against worked examples of the literature and, for the shape of Cpk's interval, the exact distribution.
#include "host/history/capability.hpp"

#include <gtest/gtest.h>

#include <boost/math/distributions/non_central_t.hpp>
#include <cmath>
#include <vector>

namespace tetragauge {
namespace {

// Amplification of 75 boosters, dB: SAS/QC User's Guide, CAPABILITY procedure, data set Amps.
const std::vector<double> kAmps{4.54, 4.87, 4.66, 4.90, 4.68, 5.22, 4.43, 5.14, 3.07, 4.22, 5.09, 3.41, 5.75,
                                5.16, 3.96, 5.37, 5.70, 4.11, 4.83, 4.51, 4.57, 4.16, 5.73, 3.64, 5.48, 4.95,
                                4.57, 4.46, 4.75, 5.38, 5.19, 4.35, 4.98, 4.87, 3.53, 4.46, 4.57, 4.69, 5.27,
                                4.67, 5.03, 4.50, 5.35, 4.55, 4.05, 6.63, 5.32, 5.24, 5.73, 5.08, 5.07, 5.42,
                                5.05, 5.70, 4.79, 4.34, 5.06, 4.64, 4.82, 3.24, 4.79, 4.46, 3.84, 5.05, 5.46,
                                4.64, 6.13, 4.31, 4.81, 4.98, 4.95, 5.57, 4.11, 4.15, 5.95};

// n values with exactly this mean and standard deviation: alternately one step above and below.
std::vector<double> values_with(size_t n, double mean, double s) {
  std::vector<double> values;
  const double count = static_cast<double>(n);
  const double step = s * std::sqrt((count - 1) / static_cast<double>(n - n % 2));
  for (size_t k = 0; k + n % 2 < n; ++k) values.push_back(mean + (k % 2 == 0 ? step : -step));
  if (n % 2 == 1) values.push_back(mean);
  return values;
}

// SAS/QC User's Guide, example "Displaying a Confidence Interval for Cpk": limits 4 and 6 dB, the 90 %
// interval by Bissell is 0.328 to 0.496.
TEST(Capability, BissellsIntervalOfThePublishedExample) {
  const Capability c = capability_of(kAmps, 4, 6, 0.90);
  ASSERT_TRUE(c.cpk && c.cpk_interval);
  EXPECT_EQ(c.n, 75u);
  EXPECT_NEAR(c.cpk_interval->low, 0.328, 0.0005);
  EXPECT_NEAR(c.cpk_interval->high, 0.496, 0.0005);
}

// Montgomery, Introduction to Statistical Quality Control, section on confidence intervals of capability
// ratios: n = 20, s = 1.75, limits 38 and 62 give Cp = 2.29 with a 95 % interval of 1.57 to 3.01. So few
// values get no index here; the ratio of interval to Cp depends on n alone, and with the table's chi-square
// of 24 degrees of freedom, 12.401 and 39.364 (NIST/SEMATECH e-Handbook 1.3.6.7.4), follows for 25.
TEST(Capability, CpIntervalFromTheChiSquareTable) {
  const Capability c = capability_of(values_with(25, 50, 1.75), 38, 62);
  ASSERT_TRUE(c.cp && c.cp_interval);
  EXPECT_NEAR(*c.cp, 24 / (6 * 1.75), 1e-9);
  EXPECT_NEAR(c.cp_interval->low, *c.cp * std::sqrt(12.401 / 24), 1e-4);
  EXPECT_NEAR(c.cp_interval->high, *c.cp * std::sqrt(39.364 / 24), 1e-4);
  // 50 values, 49 degrees of freedom: 31.555 and 70.222 in the same table.
  const Capability more = capability_of(values_with(50, 50, 1.75), 38, 62);
  EXPECT_NEAR(more.cp_interval->low, *more.cp * std::sqrt(31.555 / 49), 1e-4);
  EXPECT_NEAR(more.cp_interval->high, *more.cp * std::sqrt(70.222 / 49), 1e-4);
}

// With one limit, (upper - mean) / s sqrt(n) is exactly non-central t with delta = 3 sqrt(n) Cpk. Bissell
// takes it as normal with its first-order variance, so the tails of his interval must come near 2.5 % each.
TEST(Capability, BissellsIntervalAgainstTheExactDistribution) {
  for (const size_t n : {25u, 60u, 200u}) {
    for (const double cpk : {0.7, 1.0, 1.33, 2.0}) {
      const Capability c = capability_of(values_with(n, 1 - 3 * cpk * 0.1, 0.1), std::nullopt, 1);
      ASSERT_TRUE(c.cpk && c.cpk_interval);
      EXPECT_NEAR(*c.cpk, cpk, 1e-9);
      const double count = static_cast<double>(n), t = 3 * std::sqrt(count) * cpk;
      const auto beyond = [&](double true_cpk) {
        return boost::math::cdf(boost::math::complement(
            boost::math::non_central_t(count - 1, 3 * std::sqrt(count) * true_cpk), t));
      };
      EXPECT_NEAR(beyond(c.cpk_interval->low), 0.025, 0.012) << n << " " << cpk;
      EXPECT_NEAR(1 - beyond(c.cpk_interval->high), 0.025, 0.012) << n << " " << cpk;
    }
  }
}

TEST(Capability, OneSidedLimitsHaveNoCp) {
  const std::vector<double> values = values_with(30, 0.010, 0.002);
  const Capability upper = capability_of(values, std::nullopt, 0.020);
  EXPECT_FALSE(upper.cp || upper.cp_interval);
  EXPECT_NEAR(upper.cpk.value(), 0.010 / 0.006, 1e-9);
  const Capability lower = capability_of(values, 0.004, std::nullopt);
  EXPECT_FALSE(lower.cp);
  EXPECT_NEAR(lower.cpk.value(), 0.006 / 0.006, 1e-9);
  const Capability none = capability_of(values, std::nullopt, std::nullopt);
  EXPECT_FALSE(none.cp || none.cpk);
  EXPECT_NEAR(none.s, 0.002, 1e-12);
}

TEST(Capability, TheNearerLimitCounts) {
  const Capability c = capability_of(values_with(30, 0.04, 0.01), -0.1, 0.1);
  EXPECT_NEAR(c.cp.value(), 0.2 / 0.06, 1e-9);
  EXPECT_NEAR(c.cpk.value(), 0.06 / 0.03, 1e-9);
  const Capability beyond = capability_of(values_with(30, 0.13, 0.01), -0.1, 0.1);
  EXPECT_NEAR(beyond.cpk.value(), -1, 1e-9);
}

TEST(Capability, TooFewOrNoSpreadHaveNoIndex) {
  EXPECT_FALSE(capability_of(values_with(24, 0, 1), -5, 5).cpk);
  EXPECT_TRUE(capability_of(values_with(25, 0, 1), -5, 5).cpk);
  // 0.1 is no binary fraction: rounding must not make a spread, nor an index of 1e15.
  const Capability same = capability_of(std::vector<double>(31, 0.1), -1, 1);
  EXPECT_EQ(same.s, 0);
  EXPECT_EQ(same.mean, 0.1);
  EXPECT_FALSE(same.cp || same.cpk);
  const Capability empty = capability_of({}, -1, 1);
  EXPECT_EQ(empty.n, 0u);
  EXPECT_FALSE(empty.cpk);
}

// NIST's certified data set NumAcc3 in small: a large mean takes no digits from s.
TEST(Capability, StandardDeviationBesideALargeMean) {
  std::vector<double> values{1'000'000.2};
  for (int k = 0; k < 500; ++k) {
    values.push_back(1'000'000.1);
    values.push_back(1'000'000.3);
  }
  EXPECT_NEAR(capability_of(values, {}, {}).s, 0.1, 1e-9);
  EXPECT_NEAR(capability_of(values, {}, {}).mean, 1'000'000.2, 1e-9);
}

}  // namespace
}  // namespace tetragauge
