// SPDX-License-Identifier: GPL-3.0-or-later
// Rays against solids whose crossings are worked out here, from the definition of each body.
#include "host/solid/ray_caster.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "host/solid/test_rays.hpp"
#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

using test::count;
using test::expect_agreement;
using test::in_box;
using test::in_cylinder;
using test::in_sphere;
using test::random_ray;
using test::Ray;
using test::solid_from_csg;
using test::Span;

TEST(RayCaster, BoxAgreesWithItsSlabs) {
  const Vec3 size(10, 20, 30);
  expect_agreement(
      solid_from_csg("cube(size = [10, 20, 30], center = false);"),
      [&](const Vec3& o, const Vec3& d) { return in_box(o, d, Vec3::Zero(), size); },
      [](const Vec3&) { return false; }, 30000);
}

TEST(RayCaster, CylinderAgreesWithItsEquation) {
  expect_agreement(
      solid_from_csg("cylinder($fn = 0, h = 25, r1 = 10, r2 = 10, center = false);"),
      [](const Vec3& o, const Vec3& d) { return in_cylinder(o, d, 10, 25); },
      [](const Vec3& p) {
        const double rim = std::min(std::abs(p.z()), std::abs(p.z() - 25));
        return std::hypot(std::hypot(p.x(), p.y()) - 10, rim) < 0.03;
      },
      30000);
}

TEST(RayCaster, SphereAgreesWithItsEquation) {
  expect_agreement(
      solid_from_csg("sphere($fn = 0, r = 10);"),
      [](const Vec3& o, const Vec3& d) { return in_sphere(o, d, 10); }, [](const Vec3&) { return false; },
      30000);
}

TEST(RayCaster, ConeAgreesWithItsEquation) {
  // Radius 8 at z = 0, apex at z = 16: x^2 + y^2 <= (8 - z / 2)^2 for z in 0..16.
  const Solid solid = solid_from_csg("cylinder($fn = 0, h = 16, r1 = 8, r2 = 0, center = false);");
  const RayCaster caster(solid);
  std::mt19937_64 random(3);
  const auto height = [](const Vec3& p) { return 8 - p.z() / 2 - std::hypot(p.x(), p.y()); };
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Ray ray = random_ray(random, Vec3(0, 0, 8), 100, 10);
    const auto hit = caster.first_hit(ray.origin, ray.direction);
    if (!hit) continue;
    ++hits;
    const Vec3& p = hit->point_mm;
    const bool is_base = solid.faces()[static_cast<size_t>(hit->face)].type == SurfaceType::plane;
    if (std::abs(p.z()) < 0.03 && std::abs(std::hypot(p.x(), p.y()) - 8) < 0.03) continue;
    ASSERT_NEAR(is_base ? p.z() : height(p), 0, 1e-9);
    // Nothing of the cone lies before the hit.
    for (const double back_mm : {1e-4, 0.01, 1.0, 5.0}) {
      const Vec3 q = p - back_mm * ray.direction;
      ASSERT_TRUE(q.z() < 0 || height(q) < 0) << "ray " << i;
    }
  }
  EXPECT_GT(hits, 2000);
}

// Where a line lies in a torus about z (long double): sampled finely, each change bisected.
std::vector<Span> in_torus(const Vec3& o, const Vec3& d, long double R, long double a) {
  using L = long double;
  const auto outside = [&](L t) {
    const L x = o.x() + t * d.x(), y = o.y() + t * d.y(), z = o.z() + t * d.z();
    const L across = std::sqrt(x * x + y * y) - R;
    return across * across + z * z > a * a;
  };
  std::vector<Span> spans;
  const L middle = -o.dot(d), reach = R + a + 1;
  const int steps = 4000;
  L previous = middle - reach;
  for (int i = 1; i <= steps; ++i) {
    const L t = middle - reach + 2 * reach * i / steps;
    if (outside(t) != outside(previous)) {
      L low = previous, high = t;
      const bool is_low_outside = outside(low);
      for (int k = 0; k < 60; ++k) {
        const L half = (low + high) / 2;
        (outside(half) == is_low_outside ? low : high) = half;
      }
      if (is_low_outside) {
        spans.emplace_back(static_cast<double>(low), 0);
      } else {
        spans.back().second = static_cast<double>(low);
      }
    }
    previous = t;
  }
  return spans;
}

TEST(RayCaster, TorusAgreesWithItsEquation) {
  const Solid solid = solid_from_csg(
      "rotate_extrude(angle = 360, $fn = 0) {\n"
      "  multmatrix([[1, 0, 0, 20], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { circle($fn = 0, r = 6); } "
      "}");
  ASSERT_EQ(count(solid, SurfaceType::torus), 1);
  EXPECT_NEAR(solid.faces()[0].minor_radius_mm, 6, 1e-12);
  const RayCaster caster(solid);
  std::mt19937_64 random(19);
  int hits = 0, twice = 0;
  for (int i = 0; i < 4000; ++i) {
    const Ray ray = random_ray(random, Vec3::Zero(), 150, 24);
    const std::vector<Span> spans = in_torus(ray.origin, ray.direction, 20, 6);
    const auto hit = caster.first_hit(ray.origin, ray.direction);
    double length = 0;
    for (const Span& span : spans) length += span.second - span.first;
    const double found = caster.length_inside(ray.origin, ray.origin + 300 * ray.direction);
    // A passage shorter than the oracle's step may fall between two of its samples.
    if (found > length + 1e-6 && found - length < 0.0136) continue;
    ASSERT_EQ(hit.has_value(), !spans.empty()) << "ray " << i;
    ASSERT_NEAR(found, length, 1e-6) << "ray " << i;
    if (!hit) continue;
    ++hits;
    twice += spans.size() > 1;
    ASSERT_NEAR(hit->distance_mm, spans[0].first, 1e-6) << "ray " << i;
    ASSERT_NEAR(distance_to_surface(solid.faces()[0], hit->point_mm), 0, 1e-9);
    ASSERT_LT(hit->normal.dot(ray.direction), 0);
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(twice, 100);
}

TEST(RayCaster, GrazingHitsAreRightToAMicrometre) {
  const RayCaster cylinder(solid_from_csg("cylinder($fn = 0, h = 20, r1 = 10, r2 = 10, center = true);"));
  const RayCaster sphere(solid_from_csg("sphere($fn = 0, r = 10);"));
  const RayCaster hole(
      solid_from_csg("difference() { cube(size = [40, 40, 20], center = true);\n"
                     "  cylinder($fn = 0, h = 30, r1 = 10, r2 = 10, center = true); }"));
  for (int k = 1; k <= 9; ++k) {
    for (int turn = 0; turn < 12; ++turn) {
      // 1e-8 mm below the silhouette the path within is still 0.9 mm long.
      const double b = 10 - std::pow(10.0, 1 - k), phi = 0.1 + 2 * std::numbers::pi * turn / 12;
      const Vec3 along(std::cos(phi), std::sin(phi), 0), aside(-std::sin(phi), std::cos(phi), 0);
      const double half = std::sqrt((10 - b) * (10 + b));
      const Vec3 origin = b * aside - 100 * along + Vec3(0, 0, 1);
      const auto on_cylinder = cylinder.first_hit(origin, along);
      ASSERT_TRUE(on_cylinder) << "k " << k;
      EXPECT_NEAR(on_cylinder->distance_mm, 100 - half, 1e-3) << "k " << k;
      EXPECT_NEAR(cylinder.length_inside(origin, origin + 200 * along), 2 * half, 2e-3) << "k " << k;
      const auto on_sphere = sphere.first_hit(origin - Vec3(0, 0, 1), along);
      ASSERT_TRUE(on_sphere) << "k " << k;
      EXPECT_NEAR(on_sphere->distance_mm, 100 - half, 1e-3) << "k " << k;
      const auto in_hole = hole.first_hit(b * aside + Vec3(0, 0, 1), along);
      ASSERT_TRUE(in_hole) << "k " << k;
      EXPECT_NEAR(in_hole->distance_mm, half, 1e-3) << "k " << k;
    }
  }
  EXPECT_FALSE(cylinder.first_hit(Vec3(-100, 10 + 1e-7, 1), Vec3(1, 0, 0)));
  EXPECT_FALSE(sphere.first_hit(Vec3(-100, 10 + 1e-7, 0), Vec3(1, 0, 0)));
}

TEST(RayCaster, FarOriginsCostNothing) {
  const RayCaster caster(solid_from_csg("sphere($fn = 0, r = 10);"));
  const Vec3 direction = Vec3(1, 2, 3).normalized();
  const auto hit = caster.first_hit(-1e6 * direction + Vec3(0, 0, 1e-3), direction);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->point_mm.norm(), 10, 1e-6);
}

TEST(RayCaster, NoRayLeaksIntoAClosedPart) {
  const Solid solid =
      solid_from_csg(std::string("difference() { union() {") + test::kStaircase +
                     "} multmatrix([[1, 0, 0, 10], [0, 1, 0, 30], [0, 0, 1, -1], [0, 0, 0, 1]]) {\n"
                     "  cylinder($fn = 0, h = 80, r1 = 7, r2 = 4, center = false); } }");
  ASSERT_TRUE(solid.warnings.empty());
  const RayCaster caster(solid);
  // In the material by more than a chord's height: within the steps, above the notch or below it, and outside
  // of the hole's cone, which narrows from 7 mm at z = -1 to 4 mm at z = 79.
  const auto is_deep = [](const Vec3& p) {
    const double e = 0.05, x = p.x(), z = p.z();
    const bool is_in_steps = z < (x < 20   ? 60
                                  : x < 40 ? 50
                                  : x < 60 ? 40
                                           : 20) -
                                     e &&
                             x < 80 - e && x > e && z > e && std::abs(x - 20) > e && std::abs(x - 40) > e &&
                             std::abs(x - 60) > e;
    const bool is_in_notch = z > 10 - e && z < 40 - x + 2 * e && x < 30 + e;
    const double hole = 7 - 3 * (z + 1) / 80;
    return is_in_steps && !is_in_notch && p.y() > e && p.y() < 60 - e &&
           std::hypot(x - 10, p.y() - 30) > hole + e;
  };
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  int rays = 0;
  while (rays < 1000000) {
    const Vec3 p(80 * uniform(random), 60 * uniform(random), 60 * uniform(random));
    if (!is_deep(p)) continue;
    ++rays;
    const Vec3 origin = random_ray(random, p, 200, 0).origin;
    const Vec3 direction = (p - origin).normalized();
    const auto hit = caster.first_hit(origin, direction);
    ASSERT_TRUE(hit) << p.transpose();
    ASSERT_LT(hit->distance_mm, (p - origin).norm()) << p.transpose();
    ASSERT_LT(hit->normal.dot(direction), 1e-12) << p.transpose();
    if (rays % 10 == 0) {
      ASSERT_TRUE(caster.inside(p)) << p.transpose();
    }
  }
}

TEST(RayCaster, RaysThroughEdgesAndCornersHit) {
  const Solid solid = solid_from_csg(test::kStaircase);
  const RayCaster caster(solid);
  const Vec3 inside(50, 30, 10);
  int lines = 0;
  for (const auto& t : solid.triangles) {
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 &a = solid.vertices[t[k]], &b = solid.vertices[t[(k + 1) % 3]];
      for (const double share : {0.0, 0.25, 0.5}) {
        const Vec3 target = a + share * (b - a);
        // Where the line runs on in the material, the first surface on it is at the target or before it.
        const Vec3 direction = (inside - target).normalized();
        if (caster.length_inside(target, inside) < (inside - target).norm() - 1e-9) continue;
        ++lines;
        const auto hit = caster.first_hit(target - 200 * direction, direction);
        ASSERT_TRUE(hit);
        ASSERT_LT(hit->distance_mm, 200 + 1e-9);
      }
    }
  }
  EXPECT_GT(lines, 100);
}

TEST(RayCaster, InsideAndLengthOfAPartWithAHole) {
  const RayCaster caster(
      solid_from_csg("difference() { cube(size = [40, 40, 20], center = true);\n"
                     "  cylinder($fn = 0, h = 30, r1 = 10, r2 = 10, center = true); }"));
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-25, 25);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(uniform(random), uniform(random), uniform(random) / 2);
    const double depth = std::min(
        {20 - std::abs(p.x()), 20 - std::abs(p.y()), 10 - std::abs(p.z()), std::hypot(p.x(), p.y()) - 10});
    if (std::abs(depth) < 1e-6) continue;
    ASSERT_EQ(caster.inside(p), depth > 0) << p.transpose();
  }
  EXPECT_NEAR(caster.length_inside(Vec3(-50, 0, 0), Vec3(50, 0, 0)), 20, 1e-9);
  EXPECT_NEAR(caster.length_inside(Vec3(-15, 0, 0), Vec3(15, 0, 0)), 10, 1e-9);
  EXPECT_NEAR(caster.length_inside(Vec3(0, 0, -50), Vec3(0, 0, 50)), 0, 1e-9);
  EXPECT_NEAR(caster.length_inside(Vec3(-50, 19, 3), Vec3(-17, 19, 3)), 3, 1e-9);
}

TEST(RayCaster, OccludedLeavesTheEndsFree) {
  const RayCaster caster(solid_from_csg("cube(size = [10, 10, 10], center = false);"));
  EXPECT_TRUE(caster.occluded(Vec3(-5, 5, 5), Vec3(15, 5, 5)));
  EXPECT_FALSE(caster.occluded(Vec3(-5, 5, 5), Vec3(0, 5, 5)));
  EXPECT_FALSE(caster.occluded(Vec3(-5, 5, 5), Vec3(-5, 50, 5)));
  EXPECT_TRUE(caster.occluded(Vec3(0, 5, 5), Vec3(12, 5, 5)));
}

TEST(RayCaster, FromSkipsWhatLiesBefore) {
  const RayCaster caster(solid_from_csg("cylinder($fn = 0, h = 20, r1 = 10, r2 = 10, center = true);"));
  const Vec3 origin(-50, 0, 0), direction(1, 0, 0);
  const auto first = caster.first_hit(origin, direction);
  ASSERT_TRUE(first);
  const auto second = caster.first_hit(origin, direction, first->distance_mm + 1e-9);
  ASSERT_TRUE(second);
  EXPECT_NEAR(second->distance_mm, 60, 1e-9);
  EXPECT_GT(second->normal.dot(direction), 0.999);
  EXPECT_FALSE(caster.first_hit(origin, direction, second->distance_mm + 1e-9));
}

TEST(Transformed, MovesFacesTrianglesAndHits) {
  const Solid solid = solid_from_csg(
      "difference() { cube(size = [40, 40, 20], center = true);\n"
      "  cylinder($fn = 0, h = 30, r1 = 10, r2 = 5, center = true); }");
  const RigidTransform T{rotation_from_degrees(20, -35, 110), Vec3(5, -60, 12)};
  const Solid moved = transformed(solid, T);
  for (size_t i = 0; i < solid.faces().size(); ++i) {
    const Vec3 p = solid.faces()[i].point_mm + Vec3(0.1, 0.2, -0.3);
    EXPECT_EQ(moved.faces()[i].id, solid.faces()[i].id);
    EXPECT_NEAR(distance_to_surface(moved.faces()[i], T * p), distance_to_surface(solid.faces()[i], p), 1e-9);
  }
  const RayCaster here(solid), there(moved);
  std::mt19937_64 random(2);
  for (int i = 0; i < 2000; ++i) {
    const Ray ray = random_ray(random, Vec3::Zero(), 100, 15);
    const auto a = here.first_hit(ray.origin, ray.direction);
    const auto b = there.first_hit(T * ray.origin, T.R * ray.direction);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    ASSERT_NEAR(a->distance_mm, b->distance_mm, 1e-6);
  }
}

}  // namespace
}  // namespace tetragauge
