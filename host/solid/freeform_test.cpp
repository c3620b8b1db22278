// SPDX-License-Identifier: GPL-3.0-or-later
// Rays at free-form faces: rational B-splines that are cylinders, spheres and tori to the last digit, and a
// polynomial surface.
#include <gtest/gtest.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <Geom_BezierSurface.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <numbers>
#include <thread>

#include "host/solid/solid_from_shape.hpp"
#include "host/solid/test_rays.hpp"
#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

using test::in_cylinder;
using test::in_sphere;
using test::random_ray;
using test::Ray;
using test::Span;

Solid solid_of(const TopoDS_Shape& shape) {
  Result<Solid> solid = solid_from_shape(shape, "a test's shape", {});
  if (!solid) {
    ADD_FAILURE() << solid.error().message;
    return {};
  }
  EXPECT_TRUE(solid->warnings.empty());
  return std::move(solid).value();
}

// The same body, all its faces rational B-splines.
Solid freeform(const TopoDS_Shape& shape) {
  Solid solid = solid_of(BRepBuilderAPI_NurbsConvert(shape, true).Shape());
  EXPECT_EQ(test::count(solid, SurfaceType::other), static_cast<int>(solid.faces().size()));
  EXPECT_FALSE(solid.on_surface.empty());
  return solid;
}

TEST(Freeform, CylinderAgreesWithItsEquation) {
  test::expect_agreement(
      freeform(BRepPrimAPI_MakeCylinder(10, 25).Shape()),
      [](const Vec3& o, const Vec3& d) { return in_cylinder(o, d, 10, 25); },
      [](const Vec3& p) {
        const double rim = std::min(std::abs(p.z()), std::abs(p.z() - 25));
        return std::hypot(std::hypot(p.x(), p.y()) - 10, rim) < 0.03;
      },
      10000);
}

TEST(Freeform, SphereAgreesWithItsEquation) {
  test::expect_agreement(
      freeform(BRepPrimAPI_MakeSphere(10).Shape()),
      [](const Vec3& o, const Vec3& d) { return in_sphere(o, d, 10); }, [](const Vec3&) { return false; },
      10000);
}

TEST(Freeform, GrazingHitsAreRightToAMicrometre) {
  const RayCaster cylinder(freeform(BRepPrimAPI_MakeCylinder(10, 20).Shape()));
  const RayCaster sphere(freeform(BRepPrimAPI_MakeSphere(10).Shape()));
  for (int k = 1; k <= 7; ++k) {
    for (int turn = 0; turn < 12; ++turn) {
      const double b = 10 - std::pow(10.0, 1 - k), phi = 0.1 + 2 * std::numbers::pi * turn / 12;
      const Vec3 along(std::cos(phi), std::sin(phi), 0), aside(-std::sin(phi), std::cos(phi), 0);
      const double half = std::sqrt((10 - b) * (10 + b));
      const Vec3 origin = b * aside - 100 * along + Vec3(0, 0, 10.3);
      const auto on_cylinder = cylinder.first_hit(origin, along);
      ASSERT_TRUE(on_cylinder) << "k " << k << " turn " << turn;
      EXPECT_NEAR(on_cylinder->distance_mm, 100 - half, 1e-3) << "k " << k << " turn " << turn;
      EXPECT_NEAR(cylinder.length_inside(origin, origin + 200 * along), 2 * half, 2e-3) << "k " << k;
      const auto on_sphere = sphere.first_hit(origin - Vec3(0, 0, 10.3), along);
      ASSERT_TRUE(on_sphere) << "k " << k << " turn " << turn;
      EXPECT_NEAR(on_sphere->distance_mm, 100 - half, 1e-3) << "k " << k << " turn " << turn;
    }
  }
  EXPECT_FALSE(cylinder.first_hit(Vec3(-100, 10 + 1e-6, 1), Vec3(1, 0, 0)));
  EXPECT_FALSE(sphere.first_hit(Vec3(-100, 10 + 1e-6, 0), Vec3(1, 0, 0)));
}

TEST(Freeform, TorusAgreesWithTheAnalyticOne) {
  const Solid exact = solid_of(BRepPrimAPI_MakeTorus(20, 6).Shape());
  ASSERT_EQ(test::count(exact, SurfaceType::torus), 1);
  const RayCaster analytic(exact), spline(freeform(BRepPrimAPI_MakeTorus(20, 6).Shape()));
  std::mt19937_64 random(23);
  int hits = 0;
  for (int i = 0; i < 10000; ++i) {
    const Ray ray = random_ray(random, Vec3::Zero(), 150, 24);
    const auto a = analytic.first_hit(ray.origin, ray.direction),
               b = spline.first_hit(ray.origin, ray.direction);
    const Vec3 end = ray.origin + 300 * ray.direction;
    ASSERT_NEAR(analytic.length_inside(ray.origin, end), spline.length_inside(ray.origin, end), 1e-6) << i;
    ASSERT_EQ(a.has_value(), b.has_value()) << "ray " << i;
    if (!a) continue;
    ++hits;
    ASSERT_NEAR(a->distance_mm, b->distance_mm, 1e-6) << "ray " << i;
    ASSERT_LT((a->normal - b->normal).norm(), 1e-6) << "ray " << i;
  }
  EXPECT_GT(hits, 3000);
}

// A block on the square 0..30, from z - 20 to z = x (30 - x) / 60 + (y - 10)^3 / 800: a Bezier surface of
// degree 3 whose poles stand in even steps, so that x = 30 u, y = 30 v.
double top_mm(double x, double y) {
  return x * (30 - x) / 60 + std::pow(y - 10, 3) / 800;
}

Solid polynomial_block() {
  // Poles of a polynomial by blossoming: its polar form at (0,0,0), (0,0,1), (0,1,1), (1,1,1).
  const auto pole_x = [](int i) {  // of 15 u - 15 u^2
    const double mean = i / 3.0, pairs = i * (i - 1) / 6.0;
    return 15 * mean - 15 * pairs;
  };
  const auto pole_y = [](int j) {  // of (30 v - 10)^3 / 800
    return std::pow(-10.0, 3 - j) * std::pow(20.0, j) / 800;
  };
  TColgp_Array2OfPnt poles(1, 4, 1, 4);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) poles(i + 1, j + 1) = gp_Pnt(10.0 * i, 10.0 * j, pole_x(i) + pole_y(j));
  }
  const Handle(Geom_BezierSurface) surface = new Geom_BezierSurface(poles);
  const BRepBuilderAPI_MakeFace face(surface, 1e-7);
  return solid_of(BRepPrimAPI_MakePrism(face.Face(), gp_Vec(0, 0, -20)).Shape());
}

TEST(Freeform, PolynomialSurfaceAgreesWithItsPolynomial) {
  const Solid block = polynomial_block();
  const RayCaster caster(block);
  // The same in another frame.
  const RigidTransform T{Eigen::AngleAxisd(0.7, Vec3(1, 2, 2).normalized()).toRotationMatrix(),
                         Vec3(40, -3, 9)};
  const RayCaster moved(transformed(block, T));
  std::mt19937_64 random(31);
  int hits = 0, rims = 0;
  for (int i = 0; i < 20000; ++i) {
    const Ray ray = random_ray(random, Vec3(15, 15, 0), 80, 16);
    const auto hit = caster.first_hit(ray.origin, ray.direction);
    const auto same = moved.first_hit(T * ray.origin, T.R * ray.direction);
    ASSERT_EQ(hit.has_value(), same.has_value()) << "ray " << i;
    if (!hit) continue;
    ASSERT_NEAR(hit->distance_mm, same->distance_mm, 1e-6) << "ray " << i;
    ASSERT_LT((T.R * hit->normal - same->normal).norm(), 1e-6) << "ray " << i;
    const Vec3& p = hit->point_mm;
    const auto inset = [](const Vec3& q) { return std::min({q.x(), 30 - q.x(), q.y(), 30 - q.y()}); };
    if (inset(p) < 1e-6) continue;  // a side face
    const double to_top = p.z() - top_mm(p.x(), p.y()), off = to_top > -10 ? to_top : to_top + 20;
    if (std::abs(off) > 1e-6) {
      // Within a chord's height of an edge the triangles stand for it: a little further on, or before, the
      // ray is beyond the edge.
      ++rims;
      ASSERT_LT(std::abs(off), ReadSolidOptions().tessellation_mm) << "ray " << i;
      const Vec3 way = off / hit->normal.dot(ray.direction) * ray.direction;
      ASSERT_LT(std::min(inset(p + way), inset(p - way)), 0) << "ray " << i;
      continue;
    }
    ++hits;
    if (to_top < -10) continue;
    const Vec3 gradient(-(30 - 2 * p.x()) / 60, -3 * std::pow(p.y() - 10, 2) / 800, 1);
    ASSERT_LT((hit->normal - gradient.normalized()).norm(), 1e-6) << "ray " << i;
    // Above it all the way back within the square.
    for (const double back_mm : {1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0}) {
      const Vec3 q = p - back_mm * ray.direction;
      if (inset(q) < 0) break;
      ASSERT_GT(q.z(), top_mm(q.x(), q.y()) - 1e-9) << "ray " << i;
    }
  }
  EXPECT_GT(hits, 5000);
  EXPECT_LT(rims, 10);
}

TEST(Freeform, ThreadsAgree) {
  const RayCaster caster(polynomial_block());
  const auto cast_all = [&](std::vector<double>& distances) {
    std::mt19937_64 random(37);
    for (int i = 0; i < 3000; ++i) {
      const Ray ray = random_ray(random, Vec3(15, 15, 0), 80, 16);
      const auto hit = caster.first_hit(ray.origin, ray.direction);
      distances.push_back(hit ? hit->distance_mm : -1);
    }
  };
  std::vector<std::vector<double>> results(3);
  std::vector<std::thread> threads;
  for (auto& own : results) threads.emplace_back([&] { cast_all(own); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

}  // namespace
}  // namespace tetragauge
