// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors and matrices of the host: Eigen, double, column vectors, right-handed frames, mm and radians.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tetragauge {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

// Two unit vectors u, v with u x v = n, a pure function of n (so equal normals give equal frames everywhere).
inline std::pair<Vec3, Vec3> tangent_frame(const Vec3& n) {
  Vec3 helper = Vec3::UnitX();
  if (std::abs(n.x()) > 0.9) helper = Vec3::UnitY();
  const Vec3 u = (helper - n * n.dot(helper)).normalized();
  return {u, n.cross(u)};
}

}  // namespace tetragauge
