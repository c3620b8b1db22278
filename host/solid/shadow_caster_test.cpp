// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/shadow_caster.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

// How far inside the box 0..size the middle of the segment's stretch in it lies; negative beside it. By
// slabs.
double depth_in_box(const Vec3& a, const Vec3& b, const Vec3& size) {
  double from = 0, to = 1;
  for (int k = 0; k < 3; ++k) {
    double s = -a[k] / (b[k] - a[k]), t = (size[k] - a[k]) / (b[k] - a[k]);
    if (s > t) std::swap(s, t);
    from = std::max(from, s);
    to = std::min(to, t);
  }
  return (to - from) * (b - a).norm();
}

TEST(ShadowCaster, AgreesWithSlabsAboutABox) {
  const Vec3 size(10, 20, 30);
  const ShadowCaster shadows(test::solid_from_csg("cube(size = [10, 20, 30], center = false);"));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> near(-8, 38), far(-300, 300);
  size_t in_the_way = 0, clear = 0;
  for (int i = 0; i < 50000; ++i) {
    const Vec3 a(near(random), near(random), near(random)), b(far(random), far(random), far(random));
    const bool inside = (a.array() > -1e-3).all() && (a.array() < size.array() + 1e-3).all();
    const double depth = depth_in_box(a, b, size);
    if (inside || std::abs(depth) < 1e-3) continue;  // float tells no more at an edge
    ++(depth > 0 ? in_the_way : clear);
    EXPECT_EQ(shadows.occluded(a, b), depth > 0) << a.transpose() << " to " << b.transpose();
  }
  EXPECT_GT(in_the_way, 3000u);
  EXPECT_GT(clear, 3000u);
  EXPECT_FALSE(shadows.occluded({5, 10, 31}, {5, 10, 31}));
  EXPECT_FALSE(shadows.occluded({5, 10, 31}, {5, 10, 40}));
}

}  // namespace
}  // namespace tetragauge
