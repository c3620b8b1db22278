// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/scan/pick_points.hpp"

#include <gtest/gtest.h>

#include <array>

namespace tetragauge {
namespace {

TEST(PickPoints, EveryFieldGoesWithItsPoint) {
  Scan scan;
  scan.header.machine_id = "m";
  for (uint32_t i = 0; i < 4; ++i) {
    scan.points.emplace_back(i, 0, 0);
    scan.ray_origins.emplace_back(i, 1, 0);
    scan.sigma_mm.push_back(0.01f * static_cast<float>(i));
    scan.intensity.push_back(0.5f * static_cast<float>(i));
    scan.view.push_back(10 + i);
    scan.flags.push_back(20 + i);
  }
  const Scan picked = pick_points(scan, std::array<uint32_t, 2>{3, 1});
  ASSERT_EQ(picked.size(), 2u);
  EXPECT_EQ(picked.header.machine_id, "m");
  EXPECT_EQ(picked.points[0], Vec3(3, 0, 0));
  EXPECT_EQ(picked.points[1], Vec3(1, 0, 0));
  EXPECT_EQ(picked.ray_origins[0], Vec3(3, 1, 0));
  EXPECT_EQ(picked.sigma_mm[1], 0.01f);
  EXPECT_EQ(picked.intensity[0], 1.5f);
  EXPECT_EQ(picked.view[1], 11u);
  EXPECT_EQ(picked.flags[0], 23u);
}

}  // namespace
}  // namespace tetragauge
