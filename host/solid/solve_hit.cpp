// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/solve_hit.hpp"

#include <array>
#include <cmath>

namespace tetragauge {
namespace {

// a s^2 + 2 b s + c = 0, without cancellation (Press et al., Numerical Recipes, section 5.6).
struct Roots {
  std::array<double, 2> s{};
  int count = 0;
};

Roots solve_quadratic(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return {};
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  Roots roots;
  if (a != 0) roots.s[static_cast<size_t>(roots.count++)] = q / a;
  if (q != 0) roots.s[static_cast<size_t>(roots.count++)] = c / q;
  return roots;
}

Roots surface_roots(const Face& face, const Vec3& p, const Vec3& direction) {
  const Vec3 r = p - face.point_on_axis_mm;
  switch (face.type) {
    case SurfaceType::sphere:
      return solve_quadratic(direction.squaredNorm(), r.dot(direction),
                             (r.norm() - face.radius_mm) * (r.norm() + face.radius_mm));
    case SurfaceType::cylinder: {
      const Vec3 across = r - face.axis * face.axis.dot(r);
      const Vec3 turning = direction - face.axis * face.axis.dot(direction);
      return solve_quadratic(turning.squaredNorm(), across.dot(turning),
                             (across.norm() - face.radius_mm) * (across.norm() + face.radius_mm));
    }
    case SurfaceType::cone: {
      // across^2 = (radius + along tan)^2; the other nappe's roots are sorted out by the normal's sense.
      const double slope = std::tan(face.half_angle_rad);
      const double along = face.axis.dot(r), rise = face.axis.dot(direction);
      const Vec3 across = r - face.axis * along, turning = direction - face.axis * rise;
      const double radius = face.radius_mm + along * slope;
      return solve_quadratic(turning.squaredNorm() - slope * slope * rise * rise,
                             across.dot(turning) - radius * slope * rise,
                             (across.norm() - radius) * (across.norm() + radius));
    }
    default:
      return {};
  }
}

bool is_on_other_nappe(const Face& face, const Vec3& p) {
  if (face.type != SurfaceType::cone) return false;
  return face.radius_mm + face.axis.dot(p - face.point_on_axis_mm) * std::tan(face.half_angle_rad) < 0;
}

}  // namespace

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
    case SurfaceType::torus:
    case SurfaceType::other:
      break;
  }
  return Vec3::Zero();
}

std::optional<double> solve_hit(const Face& face, const Vec3& p, const Vec3& direction, bool is_entering) {
  if (face.type == SurfaceType::plane) {
    const double closing = face.normal.dot(direction);
    if (closing == 0) return std::nullopt;
    return (face.d_mm - face.normal.dot(p)) / closing;
  }
  const Roots roots = surface_roots(face, p, direction);
  std::optional<double> nearest;
  for (int i = 0; i < roots.count; ++i) {
    const double s = roots.s[static_cast<size_t>(i)];
    const Vec3 point = p + s * direction;
    if (is_on_other_nappe(face, point)) continue;
    const double closing = surface_normal(face, point).dot(direction);
    if (closing != 0 && (closing < 0) != is_entering) continue;
    if (!nearest || std::abs(s) < std::abs(*nearest)) nearest = s;
  }
  return nearest;
}

}  // namespace tetragauge
