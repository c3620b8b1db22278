// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/nearest_name.hpp"

#include <gtest/gtest.h>

#include <array>

namespace tetragauge {
namespace {

TEST(NearestName, FindsTheMistypedOne) {
  constexpr std::array<std::string_view, 4> kKnown{"table_deg", "slide_mm", "pitch_mm", "samples"};
  EXPECT_EQ(nearest_name("table_degrees", kKnown), "table_deg");
  EXPECT_EQ(nearest_name("slidemm", kKnown), "slide_mm");
  EXPECT_EQ(nearest_name("sample", kKnown), "samples");
  EXPECT_EQ(nearest_name("samples", kKnown), "samples");
}

TEST(NearestName, OfNothingIsEmpty) {
  EXPECT_EQ(nearest_name("x", {}), "");
}

}  // namespace
}  // namespace tetragauge
