// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "host/solid/solid.hpp"

namespace tetragauge {
namespace {

// Signed distance to one nappe of a cone, positive away from the axis. Beyond the apex the apex is nearest.
double distance_to_cone(const Face& face, const Vec3& p) {
  const Vec3 r = p - face.point_on_axis_mm;
  const double along = face.axis.dot(r);
  const double across = (r - face.axis * along).norm();
  const double sine = std::sin(face.half_angle_rad), cosine = std::cos(face.half_angle_rad);
  const double from_apex = along + face.radius_mm * cosine / sine;
  if (from_apex * cosine + across * sine < 0) return std::hypot(from_apex, across);
  return across * cosine - from_apex * sine;
}

}  // namespace

double distance_to_surface(const Face& face, const Vec3& p) {
  const double side = face.concave ? -1 : 1;
  const Vec3 r = p - face.point_on_axis_mm;
  switch (face.type) {
    case SurfaceType::plane:
      return face.normal.dot(p) - face.d_mm;
    case SurfaceType::cylinder:
      return side * (face.axis.cross(r).norm() - face.radius_mm);
    case SurfaceType::cone:
      return side * distance_to_cone(face, p);
    case SurfaceType::sphere:
      return side * (r.norm() - face.radius_mm);
    case SurfaceType::torus: {
      const double along = face.axis.dot(r);
      const double across = (r - face.axis * along).norm();
      return side * (std::hypot(across - face.radius_mm, along) - face.minor_radius_mm);
    }
    case SurfaceType::other:
      break;
  }
  return 0;
}

}  // namespace tetragauge
