// SPDX-License-Identifier: GPL-3.0-or-later
// A blade of free-form faces, from simulated rays to its deviation picture. The oracle is the blade's own
// Bezier surface, evaluated by de Casteljau's rule and projected onto by Gauss-Newton: it knows the control
// points and nothing of the pipeline.
#include <numbers>

#include "host/inspect/test_scans.hpp"
#include "host/solid/test_blade.hpp"

namespace tetragauge {
namespace {

using namespace test;

struct Bezier {
  BladeSide poles;

  Vec3 operator()(double u, double v) const {
    std::array<Vec3, 5> across;
    for (size_t i = 0; i < 5; ++i) {
      std::array<Vec3, 4> up = poles[i];
      for (size_t n = 3; n > 0; --n)
        for (size_t k = 0; k < n; ++k) up[k] += v * (up[k + 1] - up[k]);
      across[i] = up[0];
    }
    for (size_t n = 4; n > 0; --n)
      for (size_t k = 0; k < n; ++k) across[k] += u * (across[k + 1] - across[k]);
    return across[0];
  }

  Vec3 along_u(double u, double v) const { return ((*this)(u + 1e-4, v) - (*this)(u - 1e-4, v)) / 2e-4; }
  Vec3 along_v(double u, double v) const { return ((*this)(u, v + 1e-4) - (*this)(u, v - 1e-4)) / 2e-4; }

  // Distance of the nearest point, + on the side that `out` points to: Gauss-Newton from the best of a grid.
  double distance(const Vec3& p, const Vec3& out) const {
    double u = 0, v = 0, least = 1e300;
    for (int i = 0; i <= 16; ++i) {
      for (int k = 0; k <= 16; ++k) {
        const double d = ((*this)(i / 16.0, k / 16.0) - p).squaredNorm();
        if (d < least) least = d, u = i / 16.0, v = k / 16.0;
      }
    }
    Eigen::Matrix<double, 3, 2> J;
    for (int step = 0; step < 20; ++step) {
      J << along_u(u, v), along_v(u, v);
      const Eigen::Vector2d by = (J.transpose() * J).ldlt().solve(J.transpose() * (p - (*this)(u, v)));
      u = std::clamp(u + by.x(), 0.0, 1.0), v = std::clamp(v + by.y(), 0.0, 1.0);
    }
    const Vec3 off = p - (*this)(u, v), normal = J.col(0).cross(J.col(1));
    return std::copysign(off.norm(), off.dot(normal) * normal.dot(out));
  }

  // Points along its four edges.
  std::vector<Vec3> edges() const {
    std::vector<Vec3> points;
    for (int k = 0; k <= 2000; ++k)
      for (const double end : {0.0, 1.0})
        points.insert(points.end(), {(*this)(k / 2000.0, end), (*this)(end, k / 2000.0)});
    return points;
  }
};

constexpr double kHeight_mm = 60;

// One side of a blade with a chord of 40 at the foot and 28 at the tip, turned by 25 degrees. `thicker_mm`:
// how far the two control points amid it are moved towards -y.
Bezier side(const std::array<double, 5>& y, double thicker_mm) {
  Bezier out;
  for (size_t i = 0; i < 5; ++i) {
    for (size_t k = 0; k < 4; ++k) {
      const double t = static_cast<double>(k) / 3, scale = 1 - 0.3 * t;
      Vec3 p(scale * (10 * static_cast<double>(i) - 20), scale * y[i], kHeight_mm * t);
      if (i == 2 && (k == 1 || k == 2)) p.y() -= thicker_mm;
      out.poles[i][k] = Eigen::AngleAxisd(25 * t * std::numbers::pi / 180, Vec3::UnitZ()) * p;
    }
  }
  return out;
}

constexpr std::array<double, 5> kSuction_mm{0, 12, 14, 8, 0}, kPressure_mm{0, 2, 4, 3, 0};

struct Blade {
  Bezier suction = side(kSuction_mm, 0), pressure;
  explicit Blade(double thicker_mm = 0) : pressure(side(kPressure_mm, thicker_mm)) {}
  Solid solid() const { return blade(suction.poles, pressure.poles, kHeight_mm); }
};

// By how much the part's side lies outside the model's on average, along the model's normal.
double mean_made_mm(const Bezier& was, const Bezier& is, const Vec3& out) {
  double made = 0, area = 0;
  for (int a = 0; a < 40; ++a) {
    for (int b = 0; b < 40; ++b) {
      const double u = (a + 0.5) / 40, v = (b + 0.5) / 40;
      const Vec3 across = was.along_u(u, v).cross(was.along_v(u, v));
      made += std::copysign(1.0, across.dot(out)) * across.dot(is(u, v) - was(u, v));
      area += across.norm();
    }
  }
  return made / area;
}

TEST(InspectBlade, FreeFormFacesAreComparedPointByPoint) {
  const Blade nominal, actual(0.6);
  const Solid model = nominal.solid(), part = actual.solid();
  View view;
  view.points = 6000;
  const Scan scan = scan_of(part, view);
  const InspectionRun run = run_inspect(scan, model, Tolerances{});
  const RigidTransform& T = run.set_ups[0].match.T_model_part;

  // The pose is the true one, though half of the surface is off its place.
  const RigidTransform error = T * view.T_scan_model;
  EXPECT_LT((error * model.centroid_mm - model.centroid_mm).norm(), 0.02);
  EXPECT_LT(rotation_angle(error.R), 0.001);

  int free_form = 0;
  for (const Face& face : model.faces()) {
    const FaceInspection& in = result(run, face.id);
    EXPECT_TRUE(in.measured) << face.id << ": " << in.reason;
    if (face.type != SurfaceType::other) continue;
    ++free_form;
    bool is_suction = false;
    double least = 1e300;
    for (const bool suction : {false, true}) {
      double off = 0;
      for (size_t i = 0; i < scan.size(); i += 10)
        if (run.inspection.point_face[i] == face.id)
          off += std::abs(
              (suction ? nominal.suction : nominal.pressure).distance(T * scan.points[i], Vec3::UnitY()));
      if (off < least) least = off, is_suction = suction;
    }
    const Bezier& surface = is_suction ? nominal.suction : nominal.pressure;
    const Vec3 out = is_suction ? Vec3::UnitY() : Vec3(-Vec3::UnitY());
    const std::vector<Vec3> edges = surface.edges();

    // Each of its points, in the pose found: how far from the edge, and its true distance from the surface.
    struct Point {
      double from_edge_mm, deviation_mm, of_report_mm;
    };
    std::vector<Point> points;
    for (size_t i = 0; i < scan.size(); ++i) {
      if (run.inspection.point_face[i] != face.id) continue;
      const Vec3 p = T * scan.points[i];
      double from_edge = 1e300;
      for (const Vec3& on_edge : edges) from_edge = std::min(from_edge, (p - on_edge).squaredNorm());
      points.push_back(
          {from_edge, surface.distance(p, out), static_cast<double>(run.inspection.point_deviation_mm[i])});
    }
    // Those nearest to the edge are left out: which ones is settled by how many.
    ASSERT_GT(in.points_used, 1000u);
    ASSERT_GE(points.size(), in.points_used);
    EXPECT_GT(static_cast<double>(in.points_used), 0.9 * static_cast<double>(points.size()));
    std::sort(points.begin(), points.end(),
              [](const Point& a, const Point& b) { return a.from_edge_mm > b.from_edge_mm; });
    points.resize(in.points_used);
    double mean = 0, squares = 0;
    std::vector<double> sizes;
    for (const Point& point : points) {
      EXPECT_NEAR(point.of_report_mm, point.deviation_mm, 1e-4);
      mean += point.deviation_mm / static_cast<double>(points.size());
      squares += point.deviation_mm * point.deviation_mm / static_cast<double>(points.size());
      sizes.push_back(std::abs(point.deviation_mm));
    }
    std::sort(sizes.begin(), sizes.end());
    EXPECT_NEAR(in.point_mean_mm, mean, 1e-4) << is_suction;
    EXPECT_NEAR(in.point_rms_mm, std::sqrt(squares), 1e-4) << is_suction;
    EXPECT_NEAR(in.point_p95_mm, sizes[sizes.size() * 95 / 100], 1e-3) << is_suction;
    EXPECT_NEAR(in.point_max_mm, sizes.back(), 1e-3) << is_suction;

    // And by how much the part was made thicker there, whatever was measured.
    const double made = mean_made_mm(surface, is_suction ? actual.suction : actual.pressure, out);
    EXPECT_NEAR(in.point_mean_mm, made, 0.01) << is_suction;
    if (is_suction) {
      EXPECT_NEAR(in.point_rms_mm, in.machine_sigma_mm, 0.01);
    }
  }
  EXPECT_EQ(free_form, 2);
}

}  // namespace
}  // namespace tetragauge
