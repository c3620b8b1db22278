// SPDX-License-Identifier: GPL-3.0-or-later
// One doubtful tetrahedron of known shape at a side of a cube, which the emulated machine sees well: whether
// a ray could decide it follows from its geometry alone.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/measure/doubts.hpp"
#include "host/plan/test_parts.hpp"

namespace tetragauge {
namespace {

constexpr double kHalf_mm = 20;

class OneDoubt : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    part_ = new test::PlacedPart(test::placed("cube(size = [40, 40, 40], center = false);\n"));
    const auto session = start_session({.part = part_->file});
    ASSERT_TRUE(session) << session.error().message;
    const auto machine = read_machine(*session->link);
    ASSERT_TRUE(machine) << machine.error().message;
    machine_ = new PlanningMachine(*machine);
  }
  static void TearDownTestSuite() {
    delete machine_;
    delete part_;
  }

  // Three corners 1.7 mm about a spot of the side x = 20, all 3.9 mm2 of them, and one 3 mm behind (in front:
  // negative) it; the four pushed `ahead_mm` off that side.
  static Reconstruction doubt(double depth_mm, double ahead_mm, double spacing_mm, double sigma_mm) {
    Reconstruction r;
    r.vertex_spacing_mm = spacing_mm;
    const Vec3 spot(kHalf_mm + ahead_mm, 0, 20);
    for (int k = 0; k < 3; ++k) {
      const double turn = 2 * std::numbers::pi * k / 3;
      r.vertices.push_back(spot + std::sqrt(3.0) * Vec3(0, std::cos(turn), std::sin(turn)));
    }
    r.vertices.push_back(spot - Vec3(depth_mm, 0, 0));
    r.vertex_sigma_mm.assign(4, static_cast<float>(sigma_mm));
    r.vertex_ray.assign(4, Vec3(-1, 0, 0));
    r.cells.resize(1);
    r.cells[0].vertex = {0, 1, 2, 3};
    if (depth_mm > 0) std::swap(r.cells[0].vertex[0], r.cells[0].vertex[1]);
    DoubtfulTetrahedron d;
    for (const Vec3& v : r.vertices) d.centroid_mm += 0.25 * v;
    d.volume_mm3 = std::abs(depth_mm) * 2.25 * std::sqrt(3.0) / 3;
    d.look_from = Vec3::UnitX();
    r.doubtful_ranked = {d};
    r.doubtful = 1;
    return r;
  }

  static DoubtRays rays(const Reconstruction& r, std::span<const TriedRay> tried = {}) {
    return rays_at_doubts(*machine_, part_->caster, part_->T_part_model, r, 65 * std::numbers::pi / 180,
                          tried, {});
  }
  static void expect(const DoubtRays& rays, size_t open, size_t in_vain, size_t known, size_t in_noise) {
    EXPECT_EQ(rays.open.tetrahedra, open);
    EXPECT_EQ(rays.in_vain.tetrahedra, in_vain);
    EXPECT_EQ(rays.known.tetrahedra, known);
    EXPECT_EQ(rays.in_noise.tetrahedra, in_noise);
    EXPECT_EQ(rays.rays.size(), rays.tried.size());
    EXPECT_EQ(rays.rays.empty(), open == 0);
  }

  static const test::PlacedPart* part_;
  static const PlanningMachine* machine_;
};
const test::PlacedPart* OneDoubt::part_ = nullptr;
const PlanningMachine* OneDoubt::machine_ = nullptr;

TEST_F(OneDoubt, IsShotAtWhereNothingWasMeasuredYet) {
  expect(rays(doubt(3, 0, 1, 0.02)), 1, 0, 0, 0);
}

TEST_F(OneDoubt, IsKnownWhereTheRayWouldEndAmongItsCorners) {
  expect(rays(doubt(3, 0, 2, 0.02)), 0, 0, 1, 0);
  // Corners that were only put there say nothing.
  Reconstruction r = doubt(3, 0, 2, 0.02);
  r.vertex_ray.assign(4, Vec3::Zero());
  expect(rays(r), 1, 0, 0, 0);
}

TEST_F(OneDoubt, InTheAirIsDecidedByARayThatGoesThrough) {
  expect(rays(doubt(-3, 2, 2, 0.02)), 1, 0, 0, 0);
}

// V = A h / 3 with A = 3.9 mm2; the apex counts A / 3, each other corner a third of that: sigma of the volume
// is A sigma / 3 sqrt(4 / 3), and six of it are the volume at h = 6.93 sigma.
TEST_F(OneDoubt, IsNoiseWhenItIsAsThickAsNoise) {
  expect(rays(doubt(3, 0, 1, 3 / 6.8)), 0, 0, 0, 1);
  expect(rays(doubt(6.93 * 0.05 + 0.02, 2, 0.3, 0.05)), 1, 0, 0, 0);
  expect(rays(doubt(6.93 * 0.05 - 0.02, 2, 0.3, 0.05)), 0, 0, 0, 1);
}

TEST_F(OneDoubt, IsLeftAfterThreeRoundsInVain) {
  const Reconstruction r = doubt(3, 0, 1, 0.02);
  const DoubtRays first = rays(r);
  ASSERT_FALSE(first.tried.empty());
  // From elsewhere, so that only their number speaks against one more.
  std::vector<TriedRay> tried;
  for (const int round : {1, 2, 2, 3}) {
    expect(rays(r, tried), 1, 0, 0, 0);
    tried.push_back({{first.tried[0].place.table_deg + 180, first.tried[0].place.slide_mm},
                     first.tried[0].at_mm + Vec3(0, 0.6, 0),
                     round});
  }
  expect(rays(r, tried), 0, 1, 0, 0);
  for (TriedRay& ray : tried) ray.at_mm += Vec3(0, 1.2, 0);  // beyond a spacing: another question
  expect(rays(r, tried), 1, 0, 0, 0);
}

// All places within reach tried once: seen as it will be seen.
TEST_F(OneDoubt, IsNotShotAtTwiceFromAboutTheSamePlace) {
  const Reconstruction r = doubt(3, 0, 1, 0.02);
  std::vector<TriedRay> tried;
  for (int table = -180; table < 180; table += 30)
    for (int slide = -100; slide <= 400; slide += 50)
      tried.push_back({{1.0 * table, 1.0 * slide}, r.doubtful_ranked[0].centroid_mm, 1});
  expect(rays(r, tried), 0, 1, 0, 0);
}

}  // namespace
}  // namespace tetragauge
