// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/simulate/simulate.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "host/scan/scan_file.hpp"
#include "host/simulate/counter_noise.hpp"

namespace tetragauge {
namespace {

Solid solid_from_csg(const std::string& text) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
                                     (std::string("tetragauge_simulate_") + info->name() + ".csg");
  std::ofstream(path, std::ios::binary) << text;
  Result<Solid> solid = read_solid(path);
  std::filesystem::remove(path);
  if (!solid) {
    ADD_FAILURE() << solid.error().message;
    return {};
  }
  return std::move(solid).value();
}

// The thesis's staircase (Cakir 1989), mm.
constexpr const char* kStaircase =
    "multmatrix([[1, 0, 0, 0], [0, 0, -1, 60], [0, 1, 0, 0], [0, 0, 0, 1]]) {\n"
    "  linear_extrude(height = 60, scale = [1, 1]) {\n"
    "    polygon(points = [[0, 0], [80, 0], [80, 20], [60, 20], [60, 40], [40, 40], [40, 50], [20, 50], [20, "
    "60],\n"
    "      [0, 60], [0, 40], [30, 10], [0, 10]], paths = undef); } }\n";

Scan simulate_or_fail(const Solid& solid, const RayCaster& caster, const SimulateOptions& options) {
  Result<Scan> scan = simulate(solid, caster, options);
  if (!scan) {
    ADD_FAILURE() << scan.error().message;
    return {};
  }
  return std::move(scan).value();
}

TEST(CounterNoise, IsNormal) {
  constexpr int kValues = 200000;
  double sum = 0, squares = 0, fourths = 0, product = 0, previous = 0;
  int beyond_two = 0;
  for (uint64_t i = 0; i < kValues; ++i) {
    const double z = counter_normal(42, i % 7, i / 7);
    sum += z;
    squares += z * z;
    fourths += z * z * z * z;
    product += z * previous;
    previous = z;
    beyond_two += std::abs(z) > 2;
  }
  // Five standard errors of each: 1/sqrt(n), sqrt(2/n), sqrt(96/n), 1/sqrt(n), sqrt(p(1-p)/n).
  const double n = kValues, p = std::erfc(std::sqrt(2.0));
  EXPECT_NEAR(sum / n, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 1, 5 * std::sqrt(2 / n));
  EXPECT_NEAR(fourths / n, 3, 5 * std::sqrt(96 / n));
  EXPECT_NEAR(product / n, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(beyond_two / n, p, 5 * std::sqrt(p * (1 - p) / n));
}

TEST(Simulate, NoiseLiesAlongTheRayWithItsSigma) {
  // A sphere, so that the true distance along every ray is known from the ray alone.
  const Solid solid = solid_from_csg("sphere($fn = 0, r = 20);");
  const RayCaster caster(solid);
  SimulateOptions options;
  options.points = 40000;
  options.sigma_mm = 0.05;
  options.T_scan_model.t = Vec3(100, -50, 30);
  const Scan scan = simulate_or_fail(solid, caster, options);
  double sum = 0, squares = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vec3 direction = scan.ray_direction(i);
    const Vec3 o = scan.ray_origins[i] - Vec3(100, -50, 30);
    const double b = o.dot(direction);
    const double true_mm = -b - std::sqrt(b * b - o.squaredNorm() + 400);
    const double error = (scan.points[i] - scan.ray_origins[i]).norm() - true_mm;
    sum += error;
    squares += error * error;
    EXPECT_EQ(scan.sigma_mm[i], 0.05f);
  }
  const double n = static_cast<double>(scan.size());
  EXPECT_NEAR(n, 40000, 1200);
  EXPECT_NEAR(sum / n, 0, 5 * 0.05 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 0.0025, 5 * 0.0025 * std::sqrt(2 / n));
  EXPECT_EQ(scan.header.u_cal_mm, 0);
  EXPECT_EQ(scan.header.seed, 1u);
  EXPECT_TRUE(scan.rejected.empty());
}

TEST(Simulate, AnyPoseOfTheStaircaseShowsAllFifteenFaces) {
  const Solid solid = solid_from_csg(kStaircase);
  ASSERT_EQ(solid.faces().size(), 15u);
  const RayCaster caster(solid);
  std::mt19937_64 random(20);
  std::normal_distribution<double> normal;
  for (int pose = 0; pose < 21; ++pose) {
    SimulateOptions options;
    options.points = 20000;
    if (pose > 0) {
      const Eigen::Quaterniond turn(normal(random), normal(random), normal(random), normal(random));
      options.T_scan_model = {turn.normalized().toRotationMatrix(), Vec3(10, -200, 33)};
    }
    const Scan scan = simulate_or_fail(solid, caster, options);
    const RigidTransform T_model_scan = options.T_scan_model.inverse();
    std::vector<int> points(solid.faces().size());
    for (size_t i = 0; i < scan.size(); ++i) {
      const Vec3 p = T_model_scan * scan.points[i];
      // By equations alone: the face whose plane the point is on, nearest to its centroid among equal planes.
      size_t best = 0;
      double best_distance = 1e9;
      for (size_t f = 0; f < solid.faces().size(); ++f) {
        const Face& face = solid.faces()[f];
        const double distance = std::abs(distance_to_surface(face, p));
        if (distance > 0.15) continue;
        const double reach = (p - face.point_mm).norm() / std::sqrt(face.area_mm2);
        if (reach < best_distance) {
          best_distance = reach;
          best = f;
        }
      }
      ASSERT_LT(best_distance, 1e9) << "a point on no plane";
      ++points[best];
    }
    for (size_t f = 0; f < points.size(); ++f)
      EXPECT_GE(points[f], 200) << "pose " << pose << " face " << f + 1;
  }
}

TEST(Simulate, EqualBytesForAnyNumberOfThreads) {
  const Solid solid = solid_from_csg(kStaircase);
  const RayCaster caster(solid);
  SimulateOptions options;
  options.points = 5000;
  options.keep_rejected = true;
  std::string one, two;
  {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = scan_to_ply(simulate_or_fail(solid, caster, options));
  }
  {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 2);
    two = scan_to_ply(simulate_or_fail(solid, caster, options));
  }
  EXPECT_EQ(one, two);
  options.seed = 2;
  EXPECT_NE(scan_to_ply(simulate_or_fail(solid, caster, options)), one);
}

TEST(Simulate, PitchIsTheSpacingAtThePart) {
  // A thin square plate seen face on from 6 views: the two views along z see it whole.
  const Solid solid = solid_from_csg("cube(size = [40, 40, 0.02], center = true);");
  const RayCaster caster(solid);
  SimulateOptions options;
  options.views = 6;
  options.pitch_mm = 0.5;
  const Scan scan = simulate_or_fail(solid, caster, options);
  EXPECT_NEAR(static_cast<double>(scan.size()), 2 * 80 * 80, 2 * 2 * 80);
}

TEST(Simulate, SteepFacesAndMissesBecomeRejectedBeams) {
  const Solid solid = solid_from_csg("sphere($fn = 0, r = 20);");
  const RayCaster caster(solid);
  SimulateOptions options;
  options.max_incidence_rad = 0.5;
  options.keep_rejected = true;
  options.sigma_mm = 1e-6;
  const Scan scan = simulate_or_fail(solid, caster, options);
  EXPECT_FALSE(scan.rejected.empty());
  for (size_t i = 0; i < scan.size(); ++i) {
    ASSERT_GE(-scan.points[i].normalized().dot(scan.ray_direction(i)), std::cos(0.5) - 1e-6);
  }
  for (const RejectedBeam& beam : scan.rejected) ASSERT_NEAR(beam.direction.norm(), 1, 1e-12);
}

TEST(Simulate, ViewsAreUnitAndSpread) {
  for (const int views : {1, 2, 6, 8, 14, 50}) {
    const std::vector<Vec3> directions = view_directions(views);
    ASSERT_EQ(directions.size(), static_cast<size_t>(views));
    for (size_t i = 0; i < directions.size(); ++i) {
      EXPECT_NEAR(directions[i].norm(), 1, 1e-12);
      for (size_t j = 0; j < i; ++j) EXPECT_GT((directions[i] - directions[j]).norm(), 0.2);
    }
  }
}

TEST(Simulate, AWindowFromAListOfPointsHasItsRays) {
  // A sphere of radius 15 seen from 100 mm under a window of 10 x 8 degrees, all of which it fills.
  const Solid solid = solid_from_csg("sphere($fn = 0, r = 15);");
  const RayCaster caster(solid);
  SimulateOptions options;
  options.view_points_mm = {Vec3(100, 0, 0), Vec3(0, 0, 100)};
  options.window = BeamWindow{{10 * std::numbers::pi / 180, 8 * std::numbers::pi / 180}, {41, 21}};
  options.max_incidence_rad = std::numbers::pi / 2;
  const Scan scan = simulate_or_fail(solid, caster, options);
  ASSERT_EQ(scan.size(), 2u * 41 * 21);
  double widest = 0;
  int straight = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    ASSERT_EQ(scan.ray_origins[i], options.view_points_mm[scan.view[i]]);
    const double cosine = -scan.ray_direction(i).dot(scan.ray_origins[i].normalized());
    straight += cosine > 1 - 1e-6;
    widest = std::max(widest, std::acos(cosine));
  }
  EXPECT_EQ(straight, 2);  // odd counts have a middle ray
  const double a = std::tan(5 * std::numbers::pi / 180), b = std::tan(4 * std::numbers::pi / 180);
  // The middle of a round part's box is that of its triangles, 0.02 mm off at most.
  EXPECT_NEAR(widest, std::atan(std::hypot(a, b)), 0.02 / 100 * 2);
}

TEST(Simulate, AnEvenPerturbationGoesEitherWayBetweenItsEnds) {
  const Solid solid = solid_from_csg("sphere($fn = 0, r = 20);");
  const RayCaster caster(solid);
  SimulateOptions options;
  options.points = 20000;
  options.perturbation = UniformPerturbation{0.01, 0.1};
  const Scan scan = simulate_or_fail(solid, caster, options);
  double sum = 0, squares = 0, least = 1, most = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vec3 direction = scan.ray_direction(i), o = scan.ray_origins[i];
    const double b = o.dot(direction);
    const double error = (scan.points[i] - o).norm() - (-b - std::sqrt(b * b - o.squaredNorm() + 400));
    sum += error;
    squares += error * error;
    least = std::min(least, std::abs(error));
    most = std::max(most, std::abs(error));
  }
  const double n = static_cast<double>(scan.size()), square = (1e-4 + 1e-3 + 1e-2) / 3;
  EXPECT_GE(least, 0.01 - 1e-9);
  EXPECT_LE(most, 0.1 + 1e-9);
  EXPECT_LT(least, 0.0102);
  EXPECT_GT(most, 0.0998);
  EXPECT_NEAR(sum / n, 0, 5 * std::sqrt(square / n));
  EXPECT_NEAR(squares / n, square, 5 * square / std::sqrt(n));
  EXPECT_NEAR(static_cast<double>(scan.sigma_mm[0]), std::sqrt(square), 1e-7);
}

TEST(Simulate, OptionsWithoutSenseAreUsageErrors) {
  const Solid solid = solid_from_csg("cube(size = [10, 10, 10], center = true);");
  const RayCaster caster(solid);
  const auto kind = [&](auto change) {
    SimulateOptions options;
    change(options);
    const Result<Scan> scan = simulate(solid, caster, options);
    return scan ? ErrorKind::internal : scan.error().kind;
  };
  EXPECT_EQ(kind([](SimulateOptions& o) { o.views = 0; }), ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) { o.sigma_mm = 0; }), ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) { o.pitch_mm = 0; }), ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) { o.pitch_mm = 1e-5; }), ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) { o.standoff_mm = 5; }), ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) { o.pitch_mm = 1000; }), ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) { o.view_points_mm = {Vec3(1, 2, 3)}; }), ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) { o.window = BeamWindow{{4, 1}, {10, 10}}; }), ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) {
              o.window = BeamWindow{{1, 1}, {100000, 100000}};
            }),
            ErrorKind::usage);
  EXPECT_EQ(kind([](SimulateOptions& o) {
              o.perturbation = UniformPerturbation{0.1, 0.1};
            }),
            ErrorKind::usage);
}

TEST(Simulate, MoreRaysThanAScanHasIsAUsageErrorThatSaysHowMany) {
  // Seen from 8 views at 4 radii: the touching cones' circles have 16/15 of the sphere's section.
  const Solid solid = solid_from_csg("cube(size = [2000, 2000, 2000], center = true);");
  const RayCaster caster(solid);
  const double rays = 8 * std::numbers::pi * 3e6 * 16 / 15;
  const Result<Scan> fine = simulate(solid, caster);
  ASSERT_FALSE(fine);
  EXPECT_EQ(fine.error().kind, ErrorKind::usage);
  for (const char* part : {"a pitch of 1 mm", "8e+07 rays", "raise --pitch", "--points"})
    EXPECT_NE(fine.error().message.find(part), std::string::npos) << part << ": " << fine.error().message;
  EXPECT_NEAR(rays, 8e7, 0.05e7);

  SimulateOptions options;
  options.points = 100000000;
  const Result<Scan> many = simulate(solid, caster, options);
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().kind, ErrorKind::usage);
  EXPECT_NE(many.error().message.find("lower --points"), std::string::npos) << many.error().message;

  options.points = 2000;
  EXPECT_NEAR(static_cast<double>(simulate_or_fail(solid, caster, options).size()), 2000, 300);
}

}  // namespace
}  // namespace tetragauge
