// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/history/control_chart.hpp"

#include <gtest/gtest.h>

namespace tetragauge {
namespace {

// Rule of the value at `index`; 0: none.
int rule_at(const ControlChart& chart, size_t index) {
  for (const OutOfControl& signal : chart.signals)
    if (signal.index == index) return signal.rule;
  return 0;
}

// Alternating +-0.5 has moving ranges of 1: sigma is 1 / 1.128 = 0.8865 by hand.
std::vector<double> quiet(size_t n) {
  std::vector<double> values;
  for (size_t k = 0; k < n; ++k) values.push_back(k % 2 == 0 ? 0.5 : -0.5);
  return values;
}

TEST(ControlChart, CentreAndSigmaByHand) {
  const ControlChart chart = control_chart(quiet(20));
  EXPECT_NEAR(chart.centre, 0, 1e-12);
  EXPECT_NEAR(chart.sigma, 1 / 1.128, 1e-12);
  EXPECT_TRUE(chart.signals.empty());
}

TEST(ControlChart, OnePointFarOut) {
  std::vector<double> values = quiet(40);
  values[21] = 6;
  const ControlChart chart = control_chart(values);
  ASSERT_EQ(chart.signals.size(), 1u);
  EXPECT_EQ(chart.signals[0].index, 21u);
  EXPECT_EQ(chart.signals[0].rule, 1);
  values[21] = -6;
  EXPECT_EQ(rule_at(control_chart(values), 21), 1);
}

TEST(ControlChart, TwoOfThreeBeyondTwoSigma) {
  std::vector<double> values = quiet(60);
  values[30] = 2.3;
  values[32] = 2.3;  // between: -0.5 or 0.5
  const ControlChart chart = control_chart(values);
  ASSERT_GT((2.3 - chart.centre) / chart.sigma, 2);
  ASSERT_LT((2.3 - chart.centre) / chart.sigma, 3);
  EXPECT_EQ(rule_at(chart, 32), 2);
  EXPECT_EQ(rule_at(chart, 30), 0) << "one alone is none";
  EXPECT_EQ(rule_at(chart, 33), 0) << "the point itself must be beyond";
}

TEST(ControlChart, FourOfFiveBeyondOneSigma) {
  std::vector<double> values = quiet(80);
  for (const size_t k : {40u, 41u, 43u, 44u}) values[k] = 1.3;
  const ControlChart chart = control_chart(values);
  ASSERT_GT((1.3 - chart.centre) / chart.sigma, 1);
  ASSERT_LT((1.3 - chart.centre) / chart.sigma, 2);
  EXPECT_EQ(rule_at(chart, 44), 3);
  EXPECT_EQ(rule_at(chart, 43), 0);
}

TEST(ControlChart, EightOnOneSide) {
  std::vector<double> values = quiet(80);
  for (size_t k = 40; k < 48; ++k) values[k] = k % 2 == 0 ? 0.6 : 0.2;
  const ControlChart chart = control_chart(values);
  EXPECT_EQ(rule_at(chart, 46), 0);
  EXPECT_EQ(rule_at(chart, 47), 4);
}

TEST(ControlChart, NothingToSay) {
  EXPECT_TRUE(control_chart({}).signals.empty());
  EXPECT_EQ(control_chart(std::vector<double>{1}).sigma, 0);
  const ControlChart same = control_chart(std::vector<double>(20, 0.3));
  EXPECT_EQ(same.sigma, 0);
  EXPECT_TRUE(same.signals.empty());
}

}  // namespace
}  // namespace tetragauge
