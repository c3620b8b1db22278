// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/turn_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/geometry/rigid_transform.hpp"

namespace tetragauge {
namespace {

Mat3 turned(double degrees, const Vec3& axis) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()).toRotationMatrix();
}

TEST(TurnText, AnAxisHasOneWayToBeWritten) {
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_EQ(turn_text(turned(180, sign * Vec3::UnitZ())),
              "turned by 180.0 degrees about (0.000, 0.000, 1.000)");
    EXPECT_EQ(turn_text(turned(90, sign * Vec3(-1e-5, 1e-5, -1))),
              sign > 0 ? "turned by -90.0 degrees about (0.000, 0.000, 1.000)"
                       : "turned by 90.0 degrees about (0.000, 0.000, 1.000)");
    // Noise does not choose between two entries of one size.
    for (const double noise : {-1e-4, 1e-4}) EXPECT_EQ(canonical_axis(sign * Vec3(1, -1 - noise, 0)).x(), 1);
  }
}

TEST(TurnText, HalfATurnWithNoiseOnEitherSideIsTheSame) {
  for (const double degrees : {179.99, 180.0, 180.01})
    EXPECT_EQ(turn_text(turned(degrees, Vec3(0, 1, 1e-6))),
              "turned by 180.0 degrees about (0.000, 1.000, 0.000)");
}

TEST(TurnText, NoZeroHasASign) {
  EXPECT_EQ(vector_text(Vec3(-0.0, -0.0004, -0.0006), 3), "(0.000, 0.000, -0.001)");
  EXPECT_EQ(vector_text(Vec3(-0.4, 10, -0.6), 0), "(0, 10, -1)");
  EXPECT_EQ(motion_text({Mat3::Identity(), Vec3(3, -0.04, -2.96)}), "shifted by (3.0, 0.0, -3.0) mm");
}

}  // namespace
}  // namespace tetragauge
