// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/reconstruct.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "host/reconstruct/average_points.hpp"
#include "host/reconstruct/mesh_file.hpp"
#include "host/reconstruct/synthetic_scan.hpp"

namespace tetragauge {
namespace {

using synthetic::ScanPlan;

Scan scan_of(const std::vector<Vec3>& points, const Vec3& sensor, double sigma_mm = 0.01) {
  Scan scan;
  for (const Vec3& p : points) {
    scan.points.push_back(p);
    scan.ray_origins.push_back(sensor);
    scan.sigma_mm.push_back(static_cast<float>(sigma_mm));
    scan.intensity.push_back(1);
    scan.view.push_back(0);
    scan.flags.push_back(0);
  }
  return scan;
}

ScanPlan box_plan() {
  ScanPlan plan;
  plan.centre = Vec3(25, 20, 15);
  plan.half_width_mm = 40;
  plan.pitch_mm = 1.5;
  return plan;
}

TEST(Reconstruct, BoxHasItsVolumeAreaAndMoments) {
  const Scan scan = synthetic::scan_part(synthetic::box(50, 40, 30), box_plan());
  const auto r = reconstruct(scan);
  ASSERT_TRUE(r.ok()) << r.error().message;
  EXPECT_EQ(r->rays_lost, 0u);
  EXPECT_EQ(r->rays_walked, scan.size());
  EXPECT_TRUE(r->closed);
  EXPECT_EQ(r->air + r->solid, r->tetrahedra);
  // Edges without points of their own are cut off by chamfers of about the spacing h: at most h^2/2 of volume
  // per mm of edge. On top the noise layer, half a sigma over the area.
  const double h = r->vertex_spacing_mm, edges = 4 * (50 + 40 + 30), area = 2 * (50 * 40 + 40 * 30 + 50 * 30);
  EXPECT_NEAR(r->volume_mm3, 60000, 0.5 * h * h * edges + 0.5 * 0.02 * area);
  EXPECT_NEAR(r->area_mm2, area, 0.02 * area);
  EXPECT_LT((r->centroid_mm - Vec3(25, 20, 15)).norm(), 0.05);
  EXPECT_NEAR(r->inertia_mm5(0, 0), 60000.0 / 12 * (40 * 40 + 30 * 30), 0.02 * 60000.0 / 12 * 2500);
  EXPECT_NEAR(r->inertia_mm5(2, 2), 60000.0 / 12 * (50 * 50 + 40 * 40), 0.02 * 60000.0 / 12 * 4100);
}

TEST(Reconstruct, SphereHasItsVolume) {
  ScanPlan plan;
  plan.half_width_mm = 22;
  plan.pitch_mm = 1;
  const Scan scan = synthetic::scan_part(
      [](const Vec3& o, const Vec3& d) { return synthetic::hit_sphere(o, d, Vec3::Zero(), 20); }, plan);
  const auto r = reconstruct(scan);
  ASSERT_TRUE(r.ok());
  EXPECT_EQ(r->rays_lost, 0u);
  EXPECT_TRUE(r->closed);
  // An inscribed triangulation of spacing h is lower by about h^2 / 8R over the area; the noise layer adds
  // half a sigma.
  const double area = 4 * M_PI * 400, h = r->vertex_spacing_mm;
  EXPECT_NEAR(r->volume_mm3, 4.0 / 3 * M_PI * 8000, area * (h * h / (4 * 20) + 0.5 * 0.02));
}

TEST(Reconstruct, OrderOfPointsChangesNothing) {
  const Scan scan = synthetic::scan_part(synthetic::staircase(), [] {
    ScanPlan plan;
    plan.centre = Vec3(40, 30, 30);
    plan.pitch_mm = 5;
    plan.sigma_mm = 0.3;  // much noise: points are averaged
    return plan;
  }());
  const auto a = reconstruct(scan), b = reconstruct(synthetic::shuffled(scan, 3));
  ASSERT_TRUE(a.ok() && b.ok());
  ASSERT_EQ(a->vertices.size(), b->vertices.size());
  for (size_t v = 0; v < a->vertices.size(); ++v) ASSERT_EQ(a->vertices[v], b->vertices[v]);
  ASSERT_EQ(a->surface.size(), b->surface.size());
  for (size_t t = 0; t < a->surface.size(); ++t) {
    ASSERT_EQ(a->surface[t].vertex, b->surface[t].vertex);
    ASSERT_EQ(a->surface[t].neighbour, b->surface[t].neighbour);
    ASSERT_EQ(a->surface[t].unseen, b->surface[t].unseen);
    ASSERT_EQ(a->surface[t].confidence, b->surface[t].confidence);
  }
  EXPECT_EQ(a->volume_mm3, b->volume_mm3);
}

std::string bytes_of(const Reconstruction& r) {
  std::string bytes = surface_to_ply(r) + tetrahedra_to_vtu(r);
  for (const SurfaceTriangle& t : r.surface) {
    for (const int32_t n : t.neighbour) bytes += std::to_string(n) + " ";
  }
  return bytes;
}

TEST(Reconstruct, NeitherThreadsNorOrderChangeAByte) {
  ScanPlan plan;
  plan.centre = Vec3(40, 30, 30);
  plan.pitch_mm = 3;
  plan.sigma_mm = 0.1;
  const Scan scan = synthetic::scan_part(synthetic::staircase(), plan);
  for (const ReconstructMethod method : {ReconstructMethod::cut, ReconstructMethod::carve}) {
    ReconstructOptions options;
    options.method = method;
    options.keep_tetrahedra = true;
    std::string first;
    for (const size_t threads : {1, 2, 7}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const auto r = reconstruct(synthetic::shuffled(scan, threads), options);
      ASSERT_TRUE(r.ok());
      if (first.empty()) first = bytes_of(*r);
      EXPECT_TRUE(bytes_of(*r) == first) << threads << " threads";
    }
  }
}

// Noise, grids and curves are laid out along the axes: a turned scan is another problem with the same answer.
TEST(Reconstruct, MovingTheScanMovesTheAnswer) {
  const RigidTransform T{rotation_from_degrees(31, -47, 112), Vec3(300, -200, 150)};
  const auto here = reconstruct(synthetic::scan_part(synthetic::box(50, 40, 30), box_plan()));
  const auto there = reconstruct(synthetic::scan_part(synthetic::box(50, 40, 30), box_plan(), T));
  ASSERT_TRUE(here.ok() && there.ok());
  EXPECT_NEAR(there->volume_mm3, here->volume_mm3, 1e-4 * here->volume_mm3);
  EXPECT_NEAR(there->area_mm2, here->area_mm2, 2e-3 * here->area_mm2);
  EXPECT_LT((there->centroid_mm - T * here->centroid_mm).norm(), 0.01);
  const Mat3 turned = T.R * here->inertia_mm5 * T.R.transpose();
  EXPECT_LT((there->inertia_mm5 - turned).norm(), 1e-3 * turned.norm());
}

TEST(Reconstruct, FarFromTheOriginAndVerySmallAreNoDifferentCase) {
  const auto here = reconstruct(synthetic::scan_part(synthetic::box(50, 40, 30), box_plan()));
  ASSERT_TRUE(here.ok());
  const auto far = reconstruct(synthetic::scan_part(synthetic::box(50, 40, 30), box_plan(),
                                                    RigidTransform{Mat3::Identity(), Vec3(1e6, -1e6, 1e6)}));
  ASSERT_TRUE(far.ok());
  EXPECT_EQ(far->rays_lost, 0u);
  EXPECT_NEAR(far->volume_mm3, here->volume_mm3, 1e-4 * here->volume_mm3);
  Scan tiny = synthetic::scan_part(synthetic::box(50, 40, 30), box_plan());
  for (size_t i = 0; i < tiny.size(); ++i) {
    tiny.points[i] *= 1e-6;
    tiny.ray_origins[i] *= 1e-6;
    tiny.sigma_mm[i] *= 1e-6f;
  }
  const auto small = reconstruct(tiny);
  ASSERT_TRUE(small.ok());
  EXPECT_EQ(small->rays_lost, 0u);
  EXPECT_TRUE(small->closed);
  EXPECT_NEAR(small->volume_mm3 * 1e18, here->volume_mm3, 1e-3 * here->volume_mm3);
}

TEST(Reconstruct, AveragingKeepsTheSpacingAboveTheNoise) {
  // 0.5 mm pitch under 0.1 mm noise: h = sqrt(10 x 0.1 x 0.5) = 0.7 mm.
  ScanPlan plan = box_plan();
  plan.pitch_mm = 1.2;
  plan.sigma_mm = 0.2;
  const auto r = reconstruct(synthetic::scan_part(synthetic::box(50, 40, 30), plan));
  ASSERT_TRUE(r.ok());
  EXPECT_GT(r->vertex_spacing_mm, r->point_spacing_mm);
  EXPECT_NEAR(r->vertex_spacing_mm, std::sqrt(10 * 0.2 * r->point_spacing_mm), 1e-6);
  EXPECT_LT(r->vertices.size(), r->point_vertex.size());
  EXPECT_EQ(r->rays_lost, 0u);
  // No vertex is averaged across an edge: every one lies within 4 of its own sigmas of some face.
  size_t off = 0;
  for (size_t v = 0; v < r->vertices.size(); ++v) {
    const Vec3& p = r->vertices[v];
    const Vec3 size(50, 40, 30);
    double nearest = 1e9;
    for (int k = 0; k < 3; ++k) nearest = std::min({nearest, std::abs(p[k]), std::abs(p[k] - size[k])});
    if (nearest > 4 * static_cast<double>(r->vertex_sigma_mm[v])) ++off;
  }
  EXPECT_LE(off, r->vertices.size() / 1000);
}

TEST(Reconstruct, SurfaceNobodySawIsUnseen) {
  ScanPlan plan = box_plan();
  std::erase_if(plan.views, [](const Vec3& v) { return v.z() < 0.3; });  // from above only
  const auto r = reconstruct(synthetic::scan_part(synthetic::box(50, 40, 30), plan));
  ASSERT_TRUE(r.ok());
  EXPECT_TRUE(r->closed);
  double bottom = 0, seen_bottom = 0, unseen_elsewhere = 0;
  for (const SurfaceTriangle& t : r->surface) {
    const Vec3& a = r->vertices[t.vertex[0]];
    const Vec3 n = (r->vertices[t.vertex[1]] - a).cross(r->vertices[t.vertex[2]] - a);
    const bool faces_down = n.z() < -0.9 * n.norm();
    if (faces_down) {
      bottom += n.norm() / 2;
      if (!t.unseen) seen_bottom += n.norm() / 2;
    } else if (t.unseen) {
      unseen_elsewhere += n.norm() / 2;
    }
  }
  EXPECT_GT(bottom, 1800);
  EXPECT_EQ(seen_bottom, 0);
  EXPECT_LT(unseen_elsewhere, 0.02 * r->area_mm2);
}

// The staircase's tongue, 10 mm thick, under its notch: from these views the notch's depth is in shadow, and
// Delaunay tetrahedra reach from the bottom through the tongue into air. Seen surface is surface all the
// same.
TEST(Reconstruct, NoHoleThroughWhatLiesUnderAShadow) {
  synthetic::ScanPlan plan;
  plan.views.clear();
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 view(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    plan.views.push_back(rotation_from_degrees(74, 16, 142).transpose() * view.normalized());
  }
  plan.centre = Vec3(40, 30, 30);
  plan.half_width_mm = 62;
  plan.pitch_mm = 2.8;
  plan.sigma_mm = 0.03;
  for (plan.seed = 1; plan.seed <= 3; ++plan.seed) {
    const Scan scan = synthetic::scan_part(synthetic::staircase(), plan);
    const auto r = reconstruct(scan);
    ASSERT_TRUE(r.ok());
    const auto covers = [&](const SurfaceTriangle& t, double x, double y) {
      const auto turn = [&](const Vec3& a, const Vec3& b) {
        return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
      };
      const Vec3 &a = r->vertices[t.vertex[0]], &b = r->vertices[t.vertex[1]], &c = r->vertices[t.vertex[2]];
      if (std::max({std::abs(a.z()), std::abs(b.z()), std::abs(c.z())}) > 0.2) return false;
      return turn(a, b) <= 0 && turn(b, c) <= 0 && turn(c, a) <= 0;  // seen from above it is turned round
    };
    for (double x = 3; x < 77; x += 0.5) {
      for (double y = 3; y < 57; y += 0.5) {
        EXPECT_TRUE(std::any_of(r->surface.begin(), r->surface.end(),
                                [&](const SurfaceTriangle& t) { return covers(t, x, y); }))
            << "a hole at " << x << ' ' << y;
      }
    }
  }
}

TEST(Reconstruct, OnePlaneSeenFromOneSideIsASheetWithAnUnseenBack) {
  ScanPlan plan;
  plan.views = {Vec3::UnitZ()};
  plan.half_width_mm = 20;
  const auto r = reconstruct(synthetic::scan_part(synthetic::box(200, 200, 10), [&] {
    plan.centre = Vec3(100, 100, 10);
    return plan;
  }()));
  ASSERT_TRUE(r.ok());
  EXPECT_TRUE(r->closed);
  EXPECT_EQ(r->rays_lost, 0u);
  EXPECT_NEAR(r->area_mm2, 40 * 40, 160);  // the seen side
}

// A machine that stood still: one place many times, on top of a scan. With `step_mm` along the ray, not
// exactly.
Scan with_crowd(Scan scan, size_t at, size_t copies, double step_mm) {
  const Vec3 place = scan.points[at], origin = scan.ray_origins[at], ray = scan.ray_direction(at);
  for (size_t i = 0; i < copies; ++i) {
    scan.points.push_back(place + step_mm * static_cast<double>(i % 1000) * ray);
    scan.ray_origins.push_back(origin - static_cast<double>(i % 3) * ray);
    scan.sigma_mm.push_back(scan.sigma_mm[at]);
    scan.intensity.push_back(1);
    scan.view.push_back(0);
    scan.flags.push_back(0);
  }
  return scan;
}

TEST(Reconstruct, ACrowdOnOnePlaceIsOneVertexAndTakesNoSquareOfTime) {
  const Scan scan = synthetic::scan_part(synthetic::box(50, 40, 30), box_plan());
  const AveragedPoints without = average_points(scan);
  const size_t at = scan.size() / 2;
  for (const double step_mm : {0.0, 1e-7}) {
    const Scan crowded = with_crowd(scan, at, 100000, step_mm);
    // With each of the crowd asking all others this ran into the time limit of the test.
    const AveragedPoints with = average_points(crowded);
    const uint32_t crowd = with.point_vertex[at];
    EXPECT_LT((with.vertices[crowd] - scan.points[at]).norm(), 1e-3 + 1000 * step_mm);
    EXPECT_NEAR(static_cast<double>(with.sigma_mm[crowd]),
                static_cast<double>(scan.sigma_mm[at]) / std::sqrt(100001.0), 1e-7);
    for (size_t i = scan.size(); i < crowded.size(); ++i) ASSERT_EQ(with.point_vertex[i], crowd);
    // The rest of the scan does not notice.
    ASSERT_EQ(with.vertices.size(), without.vertices.size());
    for (size_t v = 0; v < with.vertices.size(); ++v) {
      if (v == crowd) continue;
      ASSERT_EQ(with.vertices[v], without.vertices[v]);
    }
  }
}

TEST(Reconstruct, NothingButOnePlaceIsAClearErrorAtOnce) {
  const auto r = reconstruct(scan_of(std::vector<Vec3>(300000, Vec3(1, 2, 3)), Vec3(0, 0, 100)));
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().kind, ErrorKind::bad_input);
}

TEST(Reconstruct, NothingToEncloseIsAClearError) {
  const Vec3 sensor(0, 0, 100);
  for (const auto& points : std::vector<std::vector<Vec3>>{
           {},
           {Vec3(1, 0, 0)},
           {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)},
           std::vector<Vec3>(10, Vec3(1, 2, 3)),
           {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0), Vec3(4, 0, 0)},
           {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(2, 1, 0)}}) {
    const auto r = reconstruct(scan_of(points, sensor));
    ASSERT_FALSE(r.ok());
    EXPECT_EQ(r.error().kind, ErrorKind::bad_input);
    EXPECT_FALSE(r.error().message.empty());
  }
  Scan broken = scan_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}, sensor);
  broken.points[2].y() = std::nan("");
  EXPECT_NE(reconstruct(broken).error().message.find("point 2"), std::string::npos);
  broken = scan_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), sensor}, sensor);
  EXPECT_NE(reconstruct(broken).error().message.find("point 3"), std::string::npos);
}

TEST(Reconstruct, DegenerateSetsGiveAResult) {
  std::vector<std::vector<Vec3>> sets(5);
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) sets[0].emplace_back(x, y, z);  // grid
      sets[1].emplace_back(x, y, 0);                              // two exact planes
      sets[1].emplace_back(x, y, 3);
      for (int copies = 0; copies < 5; ++copies) sets[2].emplace_back(x, y, x == y ? 1 : 0);  // duplicates
    }
  }
  for (int i = 0; i < 50; ++i) {
    sets[3].emplace_back(i, 0, 0);  // lines
    sets[3].emplace_back(0, i, 1);
    const double a = 2 * M_PI * i / 50;
    for (int k = -3; k <= 3; ++k)  // cospherical
      sets[4].emplace_back(10 * std::cos(a) * std::cos(0.4 * k), 10 * std::sin(a) * std::cos(0.4 * k),
                           10 * std::sin(0.4 * k));
  }
  for (const auto& points : sets) {
    for (const Vec3& sensor : {Vec3(3, 3, 100), Vec3(3.5, 3.5, 1.5), Vec3(0, 0, 50), Vec3(-1, -1, -1)}) {
      for (const ReconstructMethod method : {ReconstructMethod::cut, ReconstructMethod::carve}) {
        for (const double sigma : {0.0, 0.01, 5.0}) {
          ReconstructOptions options;
          options.method = method;
          Scan scan = scan_of(points, sensor, sigma);
          for (size_t i = 0; i < scan.size(); ++i) {
            if (scan.points[i] == sensor) scan.ray_origins[i].z() += 1;
          }
          const auto r = reconstruct(scan, options);
          if (!r) continue;  // averaging under 5 mm of noise may leave a plane
          EXPECT_EQ(r->rays_lost, 0u);
          EXPECT_TRUE(r->closed);
          EXPECT_GE(r->volume_mm3, 0);
        }
      }
    }
  }
}

TEST(Reconstruct, CarvingFindsTheSameBoxWithoutNoise) {
  ScanPlan plan = box_plan();
  plan.sigma_mm = 0;
  const Scan scan = synthetic::scan_part(synthetic::box(50, 40, 30), plan);
  ReconstructOptions options;
  options.method = ReconstructMethod::carve;
  const auto carved = reconstruct(scan, options), cut = reconstruct(scan);
  ASSERT_TRUE(carved.ok() && cut.ok());
  EXPECT_TRUE(carved->closed);
  EXPECT_NEAR(carved->volume_mm3, cut->volume_mm3, 0.01 * cut->volume_mm3);
}

}  // namespace
}  // namespace tetragauge
