// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/geometry/fit_plane_along_rays.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

namespace tetragauge {
namespace {

// A ray closer to the plane would carry its point far away.
constexpr double kLeastCosine = 0.05;
constexpr int kMostSteps = 20;
constexpr double kSettled = 1e-12;  // rad; lengths as its share of the points' spread

struct Accumulated {
  double total = 0;
  Vec3 middle = Vec3::Zero();
};

Accumulated weighted_middle(std::span<const Vec3> at, std::span<const double> weights) {
  Accumulated sum;
  for (const double w : weights) sum.total += w;
  // Twice: the first mean takes the bulk of the coordinates away, the second its rounding.
  sum.middle = at[0];
  for (int pass = 0; pass < 2; ++pass) {
    Vec3 shift = Vec3::Zero();
    for (size_t i = 0; i < at.size(); ++i) shift += weights[i] * (at[i] - sum.middle);
    sum.middle += shift / sum.total;
  }
  return sum;
}

}  // namespace

Vec3 meet_plane(const Vec3& point, const Vec3& direction, const Vec3& normal, const Vec3& on_plane) {
  const double cosine = normal.dot(direction);
  const double held = std::copysign(std::max(kLeastCosine, std::abs(cosine)), cosine);
  return point - direction * (normal.dot(point - on_plane) / held);
}

std::optional<PlaneFit> fit_plane_along_rays(std::span<const Vec3> points, std::span<const Vec3> directions,
                                             std::span<const double> weights, const Vec3& near) {
  const size_t n = points.size();
  if (n < 3) return std::nullopt;
  PlaneFit fit;
  fit.normal = near;
  fit.points = n;
  const Accumulated start = weighted_middle(points, weights);
  if (!(start.total > 0)) return std::nullopt;
  fit.centroid_mm = start.middle;

  std::vector<Vec3> at(n);
  for (int step = 0; step < kMostSteps; ++step) {
    for (size_t i = 0; i < n; ++i) at[i] = meet_plane(points[i], directions[i], fit.normal, fit.centroid_mm);
    const Vec3 middle = weighted_middle(at, weights).middle;
    const auto [u, v] = tangent_frame(fit.normal);
    fit.covariance.u = u;
    fit.covariance.v = v;
    // Height over the plane at (a, b) in (u, v) is offset + tilt_u * b - tilt_v * a: a turn about u lifts +v.
    Mat3 information = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    fit.weighted_sum_of_squares = 0;
    for (size_t i = 0; i < n; ++i) {
      const Vec3 r = at[i] - middle;
      const double height = fit.normal.dot(points[i] - fit.centroid_mm);
      const Vec3 row(1.0, r.dot(v), -r.dot(u));
      information.noalias() += weights[i] * row * row.transpose();
      right += weights[i] * height * row;
      fit.weighted_sum_of_squares += weights[i] * height * height;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> spread(information.bottomRightCorner<2, 2>());
    const Eigen::Vector2d wide = spread.eigenvalues();
    if (!(wide[0] > 1e-24 * start.total) || wide[0] <= 1e-12 * wide[1])
      return std::nullopt;  // on a point or line
    fit.covariance.matrix = information.ldlt().solve(Mat3::Identity());
    fit.covariance.matrix = 0.5 * (fit.covariance.matrix + fit.covariance.matrix.transpose()).eval();
    fit.centroid_mm = middle;
    const Vec3 change = information.ldlt().solve(right);
    const double reach = std::sqrt(wide[1] / start.total);
    if (std::abs(change[0]) <= kSettled * reach && change.tail<2>().norm() <= kSettled) break;
    fit.centroid_mm += fit.normal * change[0];
    fit.normal =
        (fit.normal + change[1] * u.cross(fit.normal) + change[2] * v.cross(fit.normal)).normalized();
    if (!(fit.normal.dot(near) > 0)) return std::nullopt;
  }
  fit.d_mm = fit.normal.dot(fit.centroid_mm);
  return fit;
}

}  // namespace tetragauge
