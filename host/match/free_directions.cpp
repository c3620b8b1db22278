// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/free_directions.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "host/match/turn_text.hpp"

namespace tetragauge {
namespace {

// Normals within half a degree of each other bound one direction, not two.
constexpr double kSameDirection_rad = 0.5 * std::numbers::pi / 180;

Vec3 canonical(const Vec3& measured) {
  Vec3 axis = canonical_axis(measured);
  for (int i = 0; i < 3; ++i)
    if (std::abs(axis[i]) < 1e-15) axis[i] = 0;
  return axis.normalized();
}

}  // namespace

std::vector<FreeDirection> free_directions(const std::vector<Vec3>& normals, const Vec3& point_mm) {
  std::vector<FreeDirection> free;
  // The span of the normals, built from those farthest apart.
  std::vector<Vec3> span;
  while (span.size() < 3) {
    Vec3 farthest = Vec3::Zero();
    for (const Vec3& normal : normals) {
      Vec3 rest = normal;
      for (const Vec3& axis : span) rest -= axis * axis.dot(normal);
      if (rest.norm() > farthest.norm() + 1e-12) farthest = rest;
    }
    if (farthest.norm() < std::sin(kSameDirection_rad)) break;
    span.push_back(farthest.normalized());
  }
  const auto translation = [&](const Vec3& axis) {
    free.push_back({FreeDirection::Kind::translation, canonical(axis), point_mm});
  };
  const auto rotation = [&](const Vec3& axis) {
    free.push_back({FreeDirection::Kind::rotation, canonical(axis), point_mm});
  };
  if (span.size() == 2) {
    translation(span[0].cross(span[1]));
  } else if (span.size() == 1) {
    const auto [u, v] = tangent_frame(canonical(span[0]));
    translation(u);
    translation(v);
    rotation(span[0]);
  } else if (span.empty()) {
    for (int k = 0; k < 3; ++k) translation(Vec3::Unit(k));
    for (int k = 0; k < 3; ++k) rotation(Vec3::Unit(k));
  }
  return free;
}

}  // namespace tetragauge
