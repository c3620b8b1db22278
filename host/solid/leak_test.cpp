// SPDX-License-Identifier: GPL-3.0-or-later
// A million random lines through closed parts of every kind of face: none is lost at an edge, and together
// they give back volume and area (Crofton's formula; Santalo, Integral Geometry and Geometric Probability,
// 1976), which the kernel has integrated.
#include <gtest/gtest.h>

#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <numbers>

#include "host/solid/solid_from_shape.hpp"
#include "host/solid/test_rays.hpp"
#include "host/solid/test_solids.hpp"

namespace tetragauge {
namespace {

struct Part {
  const char* name;
  std::string csg;
};

std::string moved(double x, double y, double z, const std::string& body) {
  std::ostringstream text;
  text << "multmatrix([[1, 0, 0, " << x << "], [0, 1, 0, " << y << "], [0, 0, 1, " << z
       << "], [0, 0, 0, 1]]) { " << body << " }\n";
  return text.str();
}

std::string round_bar(double h, double r1, double r2) {
  std::ostringstream text;
  text << "cylinder($fn = 0, h = " << h << ", r1 = " << r1 << ", r2 = " << r2 << ", center = true);";
  return text.str();
}

std::vector<Part> parts() {
  const std::string torus =
      "rotate_extrude(angle = 360, $fn = 0) { " + moved(20, 0, 0, "circle($fn = 0, r = 6);") + " }";
  return {
      {"staircase", test::kStaircase},
      {"prism of nine sides", "cylinder($fn = 9, h = 40, r1 = 20, r2 = 12, center = true);"},
      {"plate with holes and countersinks",
       "difference() { cube(size = [60, 40, 10], center = true);\n" + moved(-15, 0, 0, round_bar(20, 8, 8)) +
           moved(12, 8, 0, round_bar(20, 3, 3)) + moved(12, 8, 4, round_bar(4, 2, 6)) +
           moved(15, -10, 3, "sphere($fn = 0, r = 7);") + "}"},
      {"crossing bars", "union() { " + round_bar(60, 10, 10) +
                            "multmatrix([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]) { " +
                            round_bar(60, 8, 8) + " } }"},
      {"cone with a ball",
       "union() { " + round_bar(40, 15, 2) + moved(0, 0, 22, "sphere($fn = 0, r = 9);") + "}"},
      {"ring with a groove",
       "difference() { " + round_bar(16, 28, 28) + moved(0, 0, 0, torus) + round_bar(30, 8, 8) + "}"},
      {"torus", torus},
  };
}

struct Count {
  int rays = 0, odd = 0, unequal = 0;
  double length = 0, length_sq = 0, crossings = 0, crossings_sq = 0;
};

// Lines of every direction, evenly over the disc that the sphere about the part shows them.
void expect_no_leak(const Solid& solid, const std::string& name, int rays) {
  SCOPED_TRACE(name);
  ASSERT_TRUE(solid.warnings.empty()) << solid.warnings[0];
  const RayCaster caster(solid);
  const Vec3 middle = 0.5 * (solid.box_min_mm + solid.box_max_mm);
  const double radius = 0.5 * (solid.box_max_mm - solid.box_min_mm).norm() + 0.1;
  std::mt19937_64 random(17);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  Count count;
  for (int i = 0; i < rays; ++i) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Vec3 u = direction.unitOrthogonal(), v = direction.cross(u);
    const double r = radius * std::sqrt(uniform(random)), phi = 2 * std::numbers::pi * uniform(random);
    const Vec3 origin = middle + r * (std::cos(phi) * u + std::sin(phi) * v) - 2 * radius * direction;
    double inside_mm = 0, from = 0;
    int crossings = 0;
    bool is_in = false;
    bool is_odd = false;
    while (const auto hit = caster.first_hit(origin, direction, from)) {
      const bool is_entering = hit->normal.dot(direction) < 0;
      is_odd |= is_entering == is_in;
      if (is_in) inside_mm += hit->distance_mm - from;
      from = hit->distance_mm;
      is_in = is_entering;
      ++crossings;
    }
    is_odd |= is_in;
    const double length = caster.length_inside(origin, origin + 4 * radius * direction);
    count.odd += is_odd;
    count.unequal += std::abs(length - inside_mm) > 1e-6;
    ++count.rays;
    count.length += length;
    count.length_sq += length * length;
    count.crossings += crossings;
    count.crossings_sq += crossings * crossings;
  }
  const double n = count.rays, disc = std::numbers::pi * radius * radius;
  const auto check = [&](double sum, double sum_sq, double truth, const char* what) {
    const double mean = sum / n, sigma = std::sqrt((sum_sq / n - mean * mean) / n);
    EXPECT_NEAR(mean, truth, 4 * sigma) << what;
  };
  check(count.length, count.length_sq, solid.volume_mm3 / disc, "volume");
  check(count.crossings, count.crossings_sq, solid.area_mm2 / 2 / disc, "area");
  EXPECT_EQ(count.odd, 0);
  EXPECT_EQ(count.unequal, 0);
}

TEST(Leak, LinesThroughPartsOfEveryFace) {
  for (const Part& part : parts()) expect_no_leak(test::solid_from_csg(part.csg), part.name, 120000);
}

TEST(Leak, LinesThroughFreeformFaces) {
  BRepBuilderAPI_NurbsConvert torus(BRepPrimAPI_MakeTorus(20, 6).Shape(), true);
  const Result<Solid> solid = solid_from_shape(torus.Shape(), "a torus of splines", {});
  ASSERT_TRUE(solid) << solid.error().message;
  expect_no_leak(*solid, "torus of splines", 40000);
}

TEST(Leak, LinesThroughPartsOfOthers) {
  const std::filesystem::path folder = std::filesystem::path(TETRAGAUGE_SHARED_DATA) / "step";
  for (const char* file : {"occwl/Block_hole.step", "occwl/block_torus_fillet3.step", "occwl/four_cone.step",
                           "nist/nist_ftc_11_asme1_rb.stp", "pythonocc/face_recognition_sample_part.stp",
                           "occwl/118539_1dff9cf9_6.stp"}) {
    if (!std::filesystem::exists(folder / file))
      GTEST_SKIP() << folder / file << " is not here; the folder shared is optional";
    const Result<Solid> solid = read_solid(folder / file);
    ASSERT_TRUE(solid) << solid.error().message;
    expect_no_leak(*solid, file, 20000);
  }
}

}  // namespace
}  // namespace tetragauge
