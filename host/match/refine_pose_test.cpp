// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/refine_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tetragauge {
namespace {

constexpr double kOffset_mm = 1e-3, kTilt_rad = 2e-5;  // standard deviations: of a face about 50 mm wide

PlaneObservation face(const Vec3& normal, double d_mm, const Vec3& seen_normal, double seen_d_mm) {
  PlaneObservation out;
  out.model_normal = normal;
  out.model_d_mm = d_mm;
  out.point_mm = seen_d_mm * seen_normal;
  out.covariance.u = seen_normal.unitOrthogonal();
  out.covariance.v = seen_normal.cross(out.covariance.u);
  out.covariance.matrix =
      Vec3(kOffset_mm * kOffset_mm, kTilt_rad * kTilt_rad, kTilt_rad * kTilt_rad).asDiagonal();
  return out;
}

// A tilted face is out of place, but where no other bounds the part it is not free to slide: the middle of
// the face says where it is, less surely than one that fits. All others are in their places.
TEST(RefinePose, ATiltedFaceThatAloneBoundsThePartHoldsItLoosely) {
  const double tilt_rad = 2e-3;
  std::vector<PlaneObservation> seen;
  for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)})
    seen.push_back(face(normal, 30, normal, 30));
  seen.push_back(face(Vec3::UnitZ(), 20, Vec3(std::sin(tilt_rad), 0, std::cos(tilt_rad)), 20.01));
  const RefinedPose pose = refine_pose(seen, {}, Vec3::Zero(), 100, {});
  EXPECT_LT(rotation_angle(pose.T_model_part.R), 5 * kTilt_rad);
  EXPECT_LT(std::abs(pose.T_model_part.t.x()), 1e-3);
  EXPECT_LT(std::abs(pose.T_model_part.t.y()), 1e-3);
  // By the middle of the face the part lies 0.01 mm too high.
  EXPECT_NEAR(pose.T_model_part.t.z(), -0.01, 1e-3);
  // Half of what the tilt makes of the face at most, and no less than were it not tilted.
  const double sd_mm = std::sqrt(pose.covariance(5, 5));
  EXPECT_GT(sd_mm, kOffset_mm);
  EXPECT_LT(sd_mm, tilt_rad * 50);
}

}  // namespace
}  // namespace tetragauge
