// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/surface_samples.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {

std::vector<SurfaceSample> surface_samples(const Solid& model, size_t count) {
  std::vector<double> area_below;  // of the triangles before each
  double area = 0;
  const auto corner = [&](size_t t, size_t k) { return model.vertices[model.triangles[t][k]]; };
  for (size_t t = 0; t < model.triangles.size(); ++t) {
    area_below.push_back(area);
    area += 0.5 * (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm();
  }
  // Additive recurrence in three dimensions with the root of x^4 = x + 1 (Roberts, "The unreasonable
  // effectiveness of quasirandom sequences", 2018): one number chooses the triangle, two the place on it.
  constexpr double kRoot = 1.2207440846057596;
  std::vector<SurfaceSample> samples;
  samples.reserve(count);
  Vec3 u = Vec3::Constant(0.5);
  for (size_t i = 0; i < count && area > 0; ++i) {
    u += Vec3(1 / kRoot, 1 / (kRoot * kRoot), 1 / (kRoot * kRoot * kRoot));
    u -= u.array().floor().matrix();
    const auto above = std::upper_bound(area_below.begin(), area_below.end(), u[0] * area);
    const auto t = static_cast<size_t>(above - area_below.begin()) - 1;
    const Vec3 a = corner(t, 0), ab = corner(t, 1) - a, ac = corner(t, 2) - a;
    const Vec3 across = ab.cross(ac);
    if (!(across.norm() > 0)) continue;
    const double root = std::sqrt(u[1]);
    samples.push_back({a + root * (1 - u[2]) * ab + root * u[2] * ac, across.normalized(),
                       static_cast<int>(model.triangle_face[t])});
  }
  return samples;
}

}  // namespace tetragauge
