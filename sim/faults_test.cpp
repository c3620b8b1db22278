// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/faults.hpp"

#include <gtest/gtest.h>

namespace tetragauge::sim {
namespace {

TEST(ParseFaults, EveryWord) {
  const auto faults = parse_faults(
      "interlock@2.5s,limit_low@1s+300ms,limit_high@7s,laser_failing@4s,laser_dark@8s+1s,mirror_stuck@4s:b,"
      "flash@3s+0.2s:5uA,adc_rail@6s:2y1,link_cut@5s+2s,link_flip=1e-4,link_drop/to_host=2e-4,"
      "link_duplicate/to_machine=3e-4,link_delay=5e-5:50ms,seed=7");
  ASSERT_TRUE(faults) << faults.error().message;
  const MachineFaults& m = faults->machine;
  ASSERT_EQ(m.interlock_open.size(), 1u);
  EXPECT_FALSE(m.interlock_open[0].holds(2'499'999'999));
  EXPECT_TRUE(m.interlock_open[0].holds(2'500'000'000));
  EXPECT_TRUE(m.interlock_open[0].holds(1'000'000'000'000'000));
  ASSERT_EQ(m.limit_low.size(), 1u);
  EXPECT_TRUE(any_holds(m.limit_low, 1'299'999'999));
  EXPECT_FALSE(any_holds(m.limit_low, 1'300'000'000));
  EXPECT_EQ(m.limit_high.size(), 1u);
  EXPECT_EQ(m.laser_failing.size(), 1u);
  EXPECT_EQ(m.laser_dark.size(), 1u);
  EXPECT_TRUE(m.mirror_stuck[0].empty());
  EXPECT_EQ(m.mirror_stuck[1].size(), 1u);
  ASSERT_EQ(m.flashes.size(), 1u);
  EXPECT_DOUBLE_EQ(m.flashes[0].current_A, 5e-6);
  ASSERT_EQ(m.railed.size(), 1u);
  EXPECT_EQ(m.railed[0].camera, 1u);
  EXPECT_EQ(m.railed[0].channel, 2u);
  ASSERT_EQ(faults->line_cut.size(), 1u);
  EXPECT_EQ(faults->line_cut[0].until_ns, 7'000'000'000);
  EXPECT_EQ(faults->to_host.flip, 1e-4);
  EXPECT_EQ(faults->to_machine.flip, 1e-4);
  EXPECT_EQ(faults->to_host.drop, 2e-4);
  EXPECT_EQ(faults->to_machine.drop, 0);
  EXPECT_EQ(faults->to_host.duplicate, 0);
  EXPECT_EQ(faults->to_machine.duplicate, 3e-4);
  EXPECT_EQ(faults->to_machine.delay, 5e-5);
  EXPECT_EQ(faults->to_machine.delay_ns, 50'000'000);
  EXPECT_EQ(faults->seed, 7u);
}

TEST(ParseFaults, ErrorsNameTheWordAndWhatItShouldBe) {
  const std::pair<const char*, const char*> kCases[] = {
      {"", "empty"},
      {"seed=1,,seed=2", "between commas"},
      {"interlok@2s", "did you mean \"interlock\"?"},
      {"link_flop=1e-4", "did you mean \"link_flip\"?"},
      {"interlock", "interlock@2.5s"},
      {"interlock=3", "interlock@2.5s"},
      {"interlock@3", "with its unit"},
      {"interlock@-3s", "with its unit"},
      {"interlock@3s+", "duration"},
      {"interlock@3s+0s", "above 0"},
      {"interlock@3s:x", "takes nothing"},
      {"flash@3s:5uA", "needs a duration"},
      {"flash@3s+1s", ":5uA"},
      {"flash@3s+1s:5", ":5uA"},
      {"link_cut@5s", "needs a duration"},
      {"mirror_stuck@4s:c", ":a or :b"},
      {"mirror_stuck@4s:", ":a or :b"},
      {"adc_rail@4s:3x1", "electrode"},
      {"link_flip", "=1e-4"},
      {"link_flip@3s", "=1e-4"},
      {"link_flip=2", "from 0 to 1"},
      {"link_flip=nan", "from 0 to 1"},
      {"link_flip/both=1e-4", "/to_host or /to_machine"},
      {"link_flip/=1e-4", "/to_host or /to_machine"},
      {"link_drop=1e-4:5ms", "alone"},
      {"link_delay=1e-4:5", "with its unit"},
      {"seed=x", "whole number"},
      {"seed", "whole number"},
  };
  for (const auto& [spec, word] : kCases) {
    const auto faults = parse_faults(spec);
    ASSERT_FALSE(faults) << spec;
    EXPECT_EQ(faults.error().kind, ErrorKind::usage);
    EXPECT_NE(faults.error().message.find(word), std::string::npos) << spec << ": " << faults.error().message;
  }
}

}  // namespace
}  // namespace tetragauge::sim
