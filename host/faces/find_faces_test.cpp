// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/find_faces.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "host/reconstruct/synthetic_scan.hpp"

namespace tetragauge {
namespace {

using synthetic::ScanPlan;

struct TrueFace {
  Vec3 normal;
  double d_mm, area_mm2;
  Vec3 point_mm;  // inside the face
};

// From the polygon in ../shared/data/thesis/README.md, mm.
std::vector<TrueFace> staircase_faces() {
  const double r = std::sqrt(0.5);
  return {{{0, -1, 0}, 0, 2950, {50, 0, 20}},
          {{0, 1, 0}, 60, 2950, {50, 60, 20}},
          {{0, 0, -1}, 0, 4800, {40, 30, 0}},
          {{1, 0, 0}, 80, 1200, {80, 30, 10}},
          {{0, 0, 1}, 20, 1200, {70, 30, 20}},
          {{1, 0, 0}, 60, 1200, {60, 30, 30}},
          {{0, 0, 1}, 40, 1200, {50, 30, 40}},
          {{1, 0, 0}, 40, 600, {40, 30, 45}},
          {{0, 0, 1}, 50, 1200, {30, 30, 50}},
          {{1, 0, 0}, 20, 600, {20, 30, 55}},
          {{0, 0, 1}, 60, 1200, {10, 30, 60}},
          {{-1, 0, 0}, 0, 1200, {0, 30, 50}},
          {{-r, 0, -r}, -40 * r, 30 * std::sqrt(2.0) * 60, {15, 30, 25}},
          {{0, 0, 1}, 10, 1800, {15, 30, 10}},
          {{-1, 0, 0}, 0, 600, {0, 30, 5}}};
}

ScanPlan staircase_plan(double pitch_mm, double sigma_mm) {
  ScanPlan plan;
  plan.centre = Vec3(40, 30, 30);
  plan.half_width_mm = 62;
  plan.pitch_mm = pitch_mm;
  plan.sigma_mm = sigma_mm;
  return plan;
}

// The eight corners of a cube.
std::vector<Vec3> eight_views() {
  std::vector<Vec3> views;
  for (int i = 0; i < 8; ++i)
    views.push_back(Vec3(i & 1 ? -1 : 1, i & 2 ? -1 : 1, i & 4 ? -1 : 1).normalized());
  return views;
}

MeasuredFaces faces_of(const Scan& scan, const FindFacesOptions& options = {}) {
  const auto reconstruction = reconstruct(scan);
  EXPECT_TRUE(reconstruction.ok());
  EXPECT_EQ(reconstruction->rays_lost, 0u);
  auto faces = find_faces(scan, *reconstruction, options);
  EXPECT_TRUE(faces.ok()) << faces.error().message;
  return *std::move(faces);
}

// One standard deviation of an area, from its edges alone: each moves with the plane beyond it. A plane
// through n points spread evenly over a rectangle has 4 sigma^2 / n at the middle of a side: 1 for the
// offset, 3 for the tilt. Planes that meet at an angle move their edge by 1 / sine of that.
double area_sigma_mm2(const MeasuredFaces& measured, size_t face, double sigma_mm) {
  double variance = 0;
  for (const BoundaryLoop& loop : measured.boundaries[face]) {
    for (size_t i = 0; i < loop.size(); ++i) {
      const double length = (loop[(i + 1) % loop.size()].from_mm - loop[i].from_mm).norm();
      if (loop[i].beyond == kNoRegion) continue;
      const Face& beyond = measured.faces()[static_cast<size_t>(loop[i].beyond)];
      const Face& own = measured.faces()[face];
      const double sine = own.normal.cross(beyond.normal).norm();
      if (sine < 0.05) {  // faces of one surface part where the points do
        variance += std::pow(length, 2) * own.area_mm2 / static_cast<double>(own.points);
        continue;
      }
      variance += std::pow(length * 2 * sigma_mm / sine, 2) / static_cast<double>(beyond.points);
    }
  }
  return std::sqrt(variance);
}

// Every true face found exactly once and no other; offsets within what noise and edges allow.
void expect_staircase(const MeasuredFaces& measured, double sigma_mm,
                      const RigidTransform& T_scan_part = {}) {
  const std::vector<TrueFace> truth = staircase_faces();
  ASSERT_EQ(measured.faces().size(), truth.size());
  std::set<int> found, surfaces;
  for (const TrueFace& t : truth) {
    const Vec3 normal = T_scan_part.R * t.normal, point = T_scan_part * t.point_mm;
    int matches = 0;
    for (size_t k = 0; k < measured.faces().size(); ++k) {
      const Face& f = measured.faces()[k];
      const double reach = std::sqrt(t.area_mm2);
      if (f.normal.dot(normal) < 0.999 || std::abs(f.normal.dot(point) - f.d_mm) > 0.5 ||
          (f.point_mm - point).norm() > reach)
        continue;
      ++matches;
      found.insert(f.id);
      surfaces.insert(f.surface);
      // 4 standard errors (15 faces, many tests) and 0.02 sigma, as DESIGN section 5 wants; and the edges'
      // share 0.5 sigma^2 P / A, which is under 1e-4 sigma here.
      const double n = static_cast<double>(f.points);
      EXPECT_LE(std::abs(normal.dot(f.point_mm - point)), 4 * sigma_mm / std::sqrt(n) + 0.02 * sigma_mm)
          << "offset of the face at " << t.point_mm.transpose() << " (" << n << " points)";
      // Points spread evenly over a width w are w / sqrt(12) off its middle; each face is some 60 mm long.
      const double width = std::min(60.0, t.area_mm2 / 60);
      EXPECT_LE(std::acos(std::min(1.0, f.normal.dot(normal))),
                4 * sigma_mm / std::sqrt(n) * std::sqrt(12.0) / width);
      // Towards the tip of the notch, as far as 5 mm, its floor and its slope are in shadow.
      const bool in_notch = t.point_mm == Vec3(15, 30, 10) || t.point_mm == Vec3(15, 30, 25);
      const double shadow = in_notch ? 5 * 60 / 2.0 : 0;
      EXPECT_NEAR(f.area_mm2, t.area_mm2, 5 * area_sigma_mm2(measured, k, sigma_mm) + shadow)
          << t.point_mm.transpose();
      // Views from a cube's corners meet faces at a cosine of 1 / sqrt(3) at least.
      EXPECT_GT(measured.rms_mm[k], sigma_mm / std::sqrt(3.0) * (1 - 4 / std::sqrt(2 * n)));
      EXPECT_LT(measured.rms_mm[k], 1.1 * sigma_mm);
      EXPECT_EQ(f.points, measured.face_points[k].size());
      EXPECT_FALSE(measured.face_triangles[k].empty());
    }
    EXPECT_EQ(matches, 1) << "face at " << t.point_mm.transpose();
  }
  EXPECT_EQ(found.size(), truth.size());
  EXPECT_EQ(surfaces.size(), 14u);  // the two on x = 0 share one
}

TEST(FindFaces, StaircaseOfTwentyThousandPoints) {
  const Scan scan = synthetic::scan_part(synthetic::staircase(), staircase_plan(1.93, 0.02));
  EXPECT_NEAR(static_cast<double>(scan.size()), 20000, 1000);
  const MeasuredFaces measured = faces_of(scan);
  expect_staircase(measured, 0.02);
  EXPECT_EQ(measured.points_used + measured.points_rejected, scan.size());
  EXPECT_GT(measured.points_used, 0.9 * static_cast<double>(scan.size()));
  EXPECT_GT(measured.false_chamfers_dropped, 0u);
  for (size_t k = 1; k < measured.faces().size(); ++k)
    EXPECT_GE(measured.faces()[k - 1].area_mm2, measured.faces()[k].area_mm2);
  for (const Face& f : measured.faces()) {
    for (int n : f.neighbours) {
      const auto& back = measured.faces()[static_cast<size_t>(n - 1)].neighbours;
      EXPECT_TRUE(std::binary_search(back.begin(), back.end(), f.id));
    }
  }
}

// Thesis, chapter 5: 4077 points, perturbed uniformly by 10 to 100 um.
TEST(FindFaces, StaircaseOfTheThesisByAllThreeMethods) {
  for (const double perturbation : {0.01, 0.03, 0.1}) {
    ScanPlan plan = staircase_plan(3.455, 0);
    plan.views = eight_views();
    plan.uniform_mm = perturbation;
    const Scan scan = synthetic::scan_part(synthetic::staircase(), plan);
    EXPECT_NEAR(static_cast<double>(scan.size()), 4077, 150);
    for (const ClusterMethod method : {ClusterMethod::grow, ClusterMethod::normals, ClusterMethod::slink}) {
      SCOPED_TRACE(std::to_string(perturbation) + " mm, method " + std::to_string(static_cast<int>(method)));
      FindFacesOptions options;
      options.cluster = method;
      if (method == ClusterMethod::slink) options.single_link.count = 14;
      const MeasuredFaces measured = faces_of(scan, options);
      expect_staircase(measured, perturbation / std::sqrt(3.0));
      if (method == ClusterMethod::slink) {
        EXPECT_EQ(measured.coplanar_clusters, 14u);
      }
    }
  }
}

TEST(FindFaces, NoSuchNumberOfClusters) {
  const Scan scan = synthetic::scan_part(synthetic::box(40, 30, 20), staircase_plan(4, 0.01));
  const auto reconstruction = reconstruct(scan);
  ASSERT_TRUE(reconstruction.ok());
  FindFacesOptions options;
  options.cluster = ClusterMethod::slink;
  options.single_link.count = 5000;
  const auto faces = find_faces(scan, *reconstruction, options);
  ASSERT_FALSE(faces.ok());
  EXPECT_EQ(faces.error().kind, ErrorKind::usage);
}

// Corners where three planes meet, and volume and areas up to them.
TEST(FindFaces, BoundaryModelOfABox) {
  ScanPlan plan;
  plan.centre = Vec3(20, 15, 10);
  plan.half_width_mm = 35;
  plan.pitch_mm = 2;
  plan.sigma_mm = 0.02;
  const MeasuredFaces measured = faces_of(synthetic::scan_part(synthetic::box(40, 30, 20), plan));
  ASSERT_EQ(measured.faces().size(), 6u);
  EXPECT_NEAR(measured.volume_mm3, 40 * 30 * 20, 0.001 * 40 * 30 * 20);
  for (size_t k = 0; k < 6; ++k) {
    const Vec3 n = measured.faces()[k].normal.cwiseAbs();
    const double area = n.x() > 0.9 ? 30 * 20 : n.y() > 0.9 ? 40 * 20 : 40 * 30;
    EXPECT_NEAR(measured.faces()[k].area_mm2, area, 5 * area_sigma_mm2(measured, k, plan.sigma_mm));
    ASSERT_EQ(measured.boundaries[k].size(), 1u);
    const BoundaryLoop& loop = measured.boundaries[k].front();
    ASSERT_EQ(loop.size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        const double x = loop[i].from_mm[axis], far = Vec3(40, 30, 20)[axis];
        EXPECT_LT(std::min(std::abs(x), std::abs(x - far)), 0.02);
      }
      // The edge lies on the face beyond it too, and that one's loop has it the other way round.
      const auto beyond = static_cast<size_t>(loop[i].beyond);
      const BoundaryLoop& other = measured.boundaries[beyond].front();
      const Vec3 from = loop[i].from_mm, to = loop[(i + 1) % 4].from_mm;
      EXPECT_TRUE(std::any_of(other.begin(), other.end(), [&](const BoundaryEdge& e) {
        const auto next = static_cast<size_t>(&e - other.data() + 1) % other.size();
        return e.beyond == static_cast<int32_t>(k) && (e.from_mm - to).norm() < 1e-9 &&
               (other[next].from_mm - from).norm() < 1e-9;
      }));
    }
  }
}

TEST(FindFaces, MovingTheScanMovesTheFaces) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const double k = static_cast<double>(seed);
    const RigidTransform T{rotation_from_degrees(37 * k, 101 * k, 59 * k), Vec3(10 * k, -200, 35)};
    ScanPlan plan = staircase_plan(2.5, 0.02);
    plan.seed = seed;
    SCOPED_TRACE(seed);
    expect_staircase(faces_of(synthetic::scan_part(synthetic::staircase(), plan, T)), 0.02, T);
  }
}

TEST(FindFaces, SphereHasNoPlaneFaces) {
  for (const double pitch : {2.0, 0.8}) {
    ScanPlan plan;
    plan.half_width_mm = 22;
    plan.pitch_mm = pitch;
    const Scan scan = synthetic::scan_part(
        [](const Vec3& o, const Vec3& d) { return synthetic::hit_sphere(o, d, Vec3::Zero(), 20); }, plan);
    EXPECT_EQ(faces_of(scan).faces().size(), 0u) << "pitch " << pitch;
  }
}

// Radius 25, 60 mm long, about z: two plane ends, and a side that is not to come out in strips.
std::optional<double> hit_cylinder(const Vec3& o, const Vec3& d) {
  constexpr double kRadius = 25, kLength = 60;
  std::optional<double> best;
  const auto offer = [&](double t, bool on_it) {
    if (on_it && t > 0 && (!best || t < *best)) best = t;
  };
  for (const double z : {0.0, kLength}) {
    const double t = (z - o.z()) / d.z();
    offer(t, d.z() != 0 && (o + t * d).head<2>().norm() <= kRadius);
  }
  const double a = d.head<2>().squaredNorm(), b = o.head<2>().dot(d.head<2>()),
               c = o.head<2>().squaredNorm() - kRadius * kRadius;
  if (a > 0 && b * b >= a * c) {
    const double t = (-b - std::sqrt(b * b - a * c)) / a, z = o.z() + t * d.z();
    offer(t, z >= 0 && z <= kLength);
  }
  return best;
}

TEST(FindFaces, CylinderHasTwoPlaneFaces) {
  for (const auto& [pitch, sigma] : {std::pair{3.0, 0.05},
                                     {1.5, 0.1},
                                     {1.0, 0.1},
                                     {1.0, 0.005},
                                     {2.5, 0.03},
                                     {2.0, 0.01},
                                     {2.0, 0.05},
                                     {1.5, 0.02},
                                     {1.0, 0.02}}) {
    ScanPlan plan;
    plan.centre = Vec3(0, 0, 30);
    plan.half_width_mm = 45;
    plan.pitch_mm = pitch;
    plan.sigma_mm = sigma;
    EXPECT_EQ(faces_of(synthetic::scan_part(hit_cylinder, plan)).faces().size(), 2u)
        << "pitch " << pitch << ", sigma " << sigma;
  }
}

// A ridge and a valley of 1 degree, where noise reaches 6 mm over the edge: what lies there must not make the
// planes lean. Offsets and tilts against their own covariances, and areas up to an edge that is known.
TEST(FindFaces, FlatEdgesDoNotMakePlanesLean) {
  const double rise = 30 * std::tan(std::numbers::pi / 180);
  for (const double at_left : {-rise, rise}) {
    double chi2 = 0;
    for (uint64_t seed = 1; seed <= 4; ++seed) {
      ScanPlan plan;
      plan.centre = Vec3(30, 20, 10);
      plan.half_width_mm = 45;
      plan.pitch_mm = 1.3;
      plan.sigma_mm = 0.1;
      plan.seed = seed;
      const std::vector<Eigen::Vector2d> polygon{{0, 0}, {60, 0}, {60, 20}, {30, 20}, {0, 20 + at_left}};
      const MeasuredFaces measured = faces_of(synthetic::scan_part(synthetic::Prism{polygon, 40}, plan));
      ASSERT_EQ(measured.faces().size(), 7u) << "seed " << seed;
      for (const auto& [normal, area] : {std::pair{Vec3(0, 0, 1), 30 * 40.0},
                                         {Vec3(at_left, 0, 30).normalized(), std::hypot(30, rise) * 40}}) {
        const auto face = std::min_element(
            measured.faces().begin(), measured.faces().end(), [&](const Face& a, const Face& b) {
              return (a.normal - normal).squaredNorm() < (b.normal - normal).squaredNorm();
            });
        // The small turn w that takes the true normal to the measured one: w . u = n . v, w . v = -n . u.
        const PlaneCovariance& own = *face->covariance;
        const Vec3 error(normal.dot(face->point_mm - Vec3(30, 0, 20)), normal.dot(own.v), -normal.dot(own.u));
        chi2 += error.dot(own.matrix.inverse() * error);
        EXPECT_NEAR(face->area_mm2, area, 0.02 * area) << "seed " << seed;
      }
    }
    EXPECT_LT(chi2, 51.2);  // 99.9 % of chi-square with 4 x 2 x 3 degrees of freedom
  }
}

struct PrismCase {
  const char* name;
  std::vector<Eigen::Vector2d> polygon;  // (x, z), mm
  double length_mm, sigma_mm;
};

// Each side of the polygon and both ends, once each, and nothing else.
TEST(FindFaces, EverySideOfAPrismOnce) {
  const std::vector<PrismCase> cases = {
      {"channel", {{0, 0}, {60, 0}, {60, 40}, {40, 40}, {40, 20}, {20, 20}, {20, 40}, {0, 40}}, 50, 0.1},
      {"chamfers of 1 mm, two spacings wide", {{0, 0}, {50, 0}, {50, 29}, {49, 30}, {0, 30}}, 40, 0.03},
      {"wall of 2 mm", {{0, 0}, {60, 0}, {60, 5}, {2, 5}, {2, 40}, {0, 40}}, 40, 0.1},
      {"draft of 1 degree", {{0, 0}, {60, 0}, {60, 20}, {30, 20}, {0, 20.5237}}, 40, 0.03},
      {"draft of 1 degree under noise", {{0, 0}, {60, 0}, {60, 20}, {30, 20}, {0, 20.5237}}, 40, 0.1},
      {"step of two spacings", {{0, 0}, {60, 0}, {60, 20}, {30, 20}, {30, 22.8}, {0, 22.8}}, 58, 0.01},
      {"groove", {{0, 0}, {60, 0}, {60, 30}, {40, 30}, {30, 20}, {20, 30}, {0, 30}}, 40, 0.1}};
  for (const PrismCase& c : cases) {
    SCOPED_TRACE(c.name);
    ScanPlan plan;
    plan.centre = Vec3(30, c.length_mm / 2, 18);
    plan.half_width_mm = 50;
    plan.pitch_mm = 1.3;
    plan.sigma_mm = c.sigma_mm;
    const RigidTransform T{rotation_from_degrees(13, 29, 71), Vec3(1, 2, 3)};
    const MeasuredFaces measured =
        faces_of(synthetic::scan_part(synthetic::Prism{c.polygon, c.length_mm}, plan, T));
    EXPECT_EQ(measured.faces().size(), c.polygon.size() + 2);

    const auto count = [&](const Vec3& normal, const Vec3& middle) {
      return std::count_if(measured.faces().begin(), measured.faces().end(), [&](const Face& f) {
        // A face of n points some 1 mm wide has a tilt of a few sigma / sqrt(n) per mm.
        const double n = static_cast<double>(f.points), tilt = 0.005 + 5 * c.sigma_mm / std::sqrt(n);
        const Vec3 point = T * middle;
        return f.normal.cross(T.R * normal).norm() < tilt && f.normal.dot(T.R * normal) > 0 &&
               std::abs(f.normal.dot(point) - f.d_mm) < 0.02 + 5 * c.sigma_mm / std::sqrt(n) &&
               (f.point_mm - point).norm() < 25;
      });
    };
    EXPECT_EQ(count(-Vec3::UnitY(), Vec3(30, 0, 15)) + count(Vec3::UnitY(), Vec3(30, c.length_mm, 15)), 2);
    for (size_t i = 0; i < c.polygon.size(); ++i) {
      const Eigen::Vector2d a = c.polygon[i], b = c.polygon[(i + 1) % c.polygon.size()];
      const Vec3 normal = Vec3(b.y() - a.y(), 0, a.x() - b.x()).normalized();
      EXPECT_EQ(count(normal, Vec3((a.x() + b.x()) / 2, c.length_mm / 2, (a.y() + b.y()) / 2)), 1)
          << "side " << i;
    }
  }
}

}  // namespace
}  // namespace tetragauge
