// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid motion. A variable is named T_to_from: p_to = T_to_from * p_from.
#pragma once

#include <array>
#include <string_view>

#include "host/base/result.hpp"
#include "host/geometry/vec.hpp"

namespace tetragauge {

struct RigidTransform {
  Mat3 R = Mat3::Identity();
  Vec3 t = Vec3::Zero();  // mm

  Vec3 operator*(const Vec3& p) const { return R * p + t; }
  RigidTransform operator*(const RigidTransform& other) const { return {R * other.R, R * other.t + t}; }
  RigidTransform inverse() const { return {R.transpose(), -(R.transpose() * t)}; }
};

// R = Rz(z) Ry(y) Rx(x), angles in degrees, positive by the right hand.
Mat3 rotation_from_degrees(double x_deg, double y_deg, double z_deg);

// The angles of R = Rz Ry Rx in degrees, y within +-90; at y = +-90 x is 0.
Vec3 degrees_from_rotation(const Mat3& R);

// Angle of the rotation about its axis, radians in [0, pi]; exact for small angles.
double rotation_angle(const Mat3& R);

// "RX,RY,RZ,TX,TY,TZ" in degrees and mm: p_to = t + Rz Ry Rx p_from. Error (usage) names `option`.
Result<RigidTransform> parse_pose(std::string_view text, std::string_view option);

}  // namespace tetragauge
