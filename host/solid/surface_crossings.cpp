// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/surface_crossings.hpp"

#include <cmath>

#include "host/solid/torus_crossings.hpp"

namespace tetragauge {
namespace {

struct Quadratic {
  double a = 0, b = 0, c = 0;  // a s^2 + 2 b s + c = 0
};

Quadratic quadratic_of(const Face& face, const Vec3& p, const Vec3& direction) {
  const Vec3 r = p - face.point_on_axis_mm;
  if (face.type == SurfaceType::sphere) {
    return {direction.squaredNorm(), r.dot(direction),
            (r.norm() - face.radius_mm) * (r.norm() + face.radius_mm)};
  }
  // Cylinder and cone: across^2 = (radius + along slope)^2, with slope 0 for the cylinder.
  const double slope = face.type == SurfaceType::cone ? std::tan(face.half_angle_rad) : 0;
  const double along = face.axis.dot(r), rise = face.axis.dot(direction);
  const Vec3 across = r - face.axis * along, turning = direction - face.axis * rise;
  const double radius = face.radius_mm + along * slope;
  return {turning.squaredNorm() - slope * slope * rise * rise, across.dot(turning) - radius * slope * rise,
          (across.norm() - radius) * (across.norm() + radius)};
}

bool is_on_other_nappe(const Face& face, const Vec3& p) {
  if (face.type != SurfaceType::cone) return false;
  return face.radius_mm + face.axis.dot(p - face.point_on_axis_mm) * std::tan(face.half_angle_rad) < 0;
}

}  // namespace

bool has_crossings(const Face& face) {
  if (face.type == SurfaceType::torus) return face.minor_radius_mm < face.radius_mm;
  return face.type != SurfaceType::other;
}

Vec3 surface_normal(const Face& face, const Vec3& p) {
  const double side = face.concave ? -1 : 1;
  const Vec3 r = p - face.point_on_axis_mm;
  switch (face.type) {
    case SurfaceType::plane:
      return face.normal;
    case SurfaceType::sphere:
      return side * r.normalized();
    case SurfaceType::cylinder:
      return side * (r - face.axis * face.axis.dot(r)).normalized();
    case SurfaceType::cone: {
      const Vec3 across = (r - face.axis * face.axis.dot(r)).normalized();
      return side * (across * std::cos(face.half_angle_rad) - face.axis * std::sin(face.half_angle_rad));
    }
    case SurfaceType::torus: {
      if (!has_crossings(face)) break;
      const Vec3 radial = (r - face.axis * face.axis.dot(r)).normalized();
      return side * (r - face.radius_mm * radial).normalized();
    }
    case SurfaceType::other:
      break;
  }
  return Vec3::Zero();
}

SurfaceCrossings surface_crossings(const Face& face, const Vec3& p, const Vec3& direction) {
  SurfaceCrossings crossings;
  const auto add = [&](double s, bool is_entering) {
    crossings.s[crossings.count] = s;
    crossings.is_entering[crossings.count++] = is_entering;
  };
  if (!has_crossings(face)) return crossings;
  if (face.type == SurfaceType::plane) {
    const double closing = face.normal.dot(direction);
    if (closing != 0) add((face.d_mm - face.normal.dot(p)) / closing, closing < 0);
    return crossings;
  }
  if (face.type == SurfaceType::torus) {
    const TorusCrossings torus = torus_crossings(face, p, direction);
    for (size_t i = 0; i < torus.count; ++i) add(torus.s[i], torus.is_inward[i] != face.concave);
    return crossings;
  }
  const auto [a, b, c] = quadratic_of(face, p, direction);
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return crossings;
  // Without cancellation (Press et al., Numerical Recipes, section 5.6).
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  const bool has_both = a != 0 && q != 0;
  const double one = a != 0 ? q / a : c / q, other = has_both ? c / q : one;
  if (a == 0 && q == 0) return crossings;
  // The quadratic falls where the line runs towards the axis: that way is into a convex body.
  for (const double s : has_both ? std::array<double, 2>{std::min(one, other), std::max(one, other)}
                                 : std::array<double, 2>{one, one}) {
    if (crossings.count > 0 && !has_both) break;
    if (is_on_other_nappe(face, p + s * direction)) continue;
    add(s, (a * s + b < 0) != face.concave);
  }
  return crossings;
}

}  // namespace tetragauge
