// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/match_scans.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "host/match/match.hpp"
#include "host/simulate/simulate.hpp"
#include "tests/bench/match_trials.hpp"

namespace tetragauge::bench {
namespace {

constexpr double kDeg = std::numbers::pi / 180;

RigidTransform random_pose(uint64_t seed) {
  std::mt19937_64 random(seed * 0x9e3779b97f4a7c15u + 7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
  };
  const double x = uniform(-180, 180), y = uniform(-90, 90), z = uniform(-180, 180);
  return {rotation_from_degrees(x, y, z), Vec3(uniform(-50, 50), uniform(-50, 50), uniform(-50, 50))};
}

// What the points can tell about the pose at best, each knowing the face that its beam met: the inverse of
// the sum of J' J / s^2, s being sigma across the face.
Mat6 cramer_rao(const Solid& solid, const RayCaster& caster, const Scan& scan,
                const RigidTransform& T_model_scan) {
  Mat6 information = Mat6::Zero();
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vec3 direction = T_model_scan.R * scan.ray_direction(i);
    const auto hit = caster.first_hit(T_model_scan * scan.ray_origins[i], direction);
    if (!hit) continue;
    Vec6 row;
    row << (hit->point_mm - solid.centroid_mm).cross(hit->normal), hit->normal;
    const double s = static_cast<double>(scan.sigma_mm[i]) * std::abs(hit->normal.dot(direction));
    information += row * row.transpose() / (s * s);
  }
  return information.ldlt().solve(Mat6::Identity());
}

Vec6 error_of(const RigidTransform& error, const Vec3& pivot) {
  const Eigen::AngleAxisd turn(error.R);
  Vec6 e;
  e << turn.angle() * turn.axis(), error * pivot - pivot;
  return e;
}

}  // namespace

Result<ScanTrial> scan_trial(const Solid& solid, const ScanTrialOptions& options) {
  const RayCaster caster(solid);
  SimulateOptions how;
  how.points = options.points;
  how.sigma_mm = options.sigma_mm;
  how.seed = options.seed;
  how.T_scan_model = random_pose(options.seed);
  if (options.from_two_sides) {
    // Two neighbouring corners of the part's box, from as far as the views all round.
    const double far_mm = 2 * (solid.box_max_mm - solid.box_min_mm).norm();
    const Vec3 middle = 0.5 * (solid.box_min_mm + solid.box_max_mm);
    for (const Vec3& direction : {Vec3(0.62, 0.55, 0.56), Vec3(-0.58, 0.5, 0.64)})
      how.view_points_mm.push_back(how.T_scan_model * (middle + far_mm * direction.normalized()));
  }
  Result<Scan> scan = simulate(solid, caster, how);
  if (!scan) return scan.error();
  const Mat6 bound = cramer_rao(solid, caster, *scan, how.T_scan_model.inverse());

  ScanTrial out;
  out.bound_turn_urad = 1e6 * std::sqrt(bound.topLeftCorner<3, 3>().trace());
  out.bound_shift_um = 1e3 * std::sqrt(bound.bottomRightCorner<3, 3>().trace());
  const Result<Reconstruction> reconstruction = reconstruct(*scan);
  if (!reconstruction) {
    out.error = reconstruction.error().message;
    return out;
  }
  const Result<MeasuredFaces> faces = find_faces(*scan, *reconstruction);
  if (!faces) {
    out.error = faces.error().message;
    return out;
  }
  const double start_ms = processor_ms();
  const Result<Match> match = match_scan(solid, caster, *scan, *faces);
  out.match_s = 1e-3 * (processor_ms() - start_ms);
  if (!match) {
    out.error = match.error().message;
    return out;
  }
  out.poses = 1 + match->equivalents.size();
  out.free_directions = match->undetermined.size();

  // The truth in the nearest of the part's own symmetries.
  const RigidTransform found = match->T_model_part * how.T_scan_model;
  Vec6 e = error_of(found, solid.centroid_mm);
  const auto size = [](const Vec6& v) { return v.tail<3>().norm() + 50 * v.head<3>().norm(); };
  for (const RigidTransform& symmetry : symmetries(solid.list)) {
    const Vec6 other = error_of(found * symmetry.inverse(), solid.centroid_mm);
    if (size(other) < size(e)) e = other;
  }
  for (const FreeDirection& free : match->undetermined)
    if (free.kind == FreeDirection::Kind::translation) e.tail<3>() -= free.axis * free.axis.dot(e.tail<3>());
  out.turn_urad = 1e6 * e.head<3>().norm();
  out.shift_um = 1e3 * e.tail<3>().norm();
  out.right = out.turn_urad < std::max(0.1e6 * kDeg, 10 * out.bound_turn_urad) &&
              out.shift_um < std::max(100.0, 10 * out.bound_shift_um);
  out.ratio2_bound = e.dot(bound.ldlt().solve(e)) / 6;
  out.mahalanobis2 = e.dot(match->covariance.ldlt().solve(e));
  return out;
}

}  // namespace tetragauge::bench
