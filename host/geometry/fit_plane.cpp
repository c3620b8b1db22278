// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/geometry/fit_plane.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace tetragauge {

std::optional<PlaneFit> fit_plane(std::span<const Vec3> points, std::span<const double> weights,
                                  const Vec3& towards) {
  const size_t n = points.size();
  if (n < 3) return std::nullopt;
  const auto weight = [&](size_t i) { return weights.empty() ? 1.0 : weights[i]; };

  // Centre twice: the first mean takes the bulk of the coordinates away, the second its rounding.
  double total = 0;
  for (size_t i = 0; i < n; ++i) total += weight(i);
  if (!(total > 0)) return std::nullopt;
  Vec3 centroid = points[0];
  for (int pass = 0; pass < 2; ++pass) {
    Vec3 sum = Vec3::Zero();
    for (size_t i = 0; i < n; ++i) sum += weight(i) * (points[i] - centroid);
    centroid += sum / total;
  }
  Mat3 scatter = Mat3::Zero();
  for (size_t i = 0; i < n; ++i) {
    const Vec3 r = points[i] - centroid;
    scatter.noalias() += weight(i) * r * r.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(scatter);
  const Vec3 spread = eigen.eigenvalues();  // ascending
  if (!(spread[1] > 1e-24 * total) || spread[1] <= 1e-12 * spread[2])
    return std::nullopt;  // on a point or line
  Vec3 normal = eigen.eigenvectors().col(0);

  // The scatter squares the condition number; one Gauss-Newton step on the residuals restores full precision.
  for (int pass = 0; pass < 2; ++pass) {
    const auto [u, v] = tangent_frame(normal);
    Eigen::Matrix3d normal_equations = Eigen::Matrix3d::Zero();
    Vec3 right = Vec3::Zero();
    for (size_t i = 0; i < n; ++i) {
      const Vec3 r = points[i] - centroid;
      const Vec3 row(1.0, r.dot(u), r.dot(v));
      normal_equations.noalias() += weight(i) * row * row.transpose();
      right += weight(i) * row * r.dot(normal);
    }
    const Vec3 step = normal_equations.ldlt().solve(right);  // height = a + b u + c v
    centroid += normal * step[0];
    normal = (normal - step[1] * u - step[2] * v).normalized();
  }
  if (normal.dot(towards) < 0) normal = -normal;

  PlaneFit fit;
  fit.normal = normal;
  fit.centroid_mm = centroid;
  fit.d_mm = normal.dot(centroid);
  fit.points = n;
  const auto [u, v] = tangent_frame(normal);
  fit.covariance.u = u;
  fit.covariance.v = v;
  // Height over the plane at (a, b) in (u, v) is offset + tilt_u * b - tilt_v * a: a turn about u lifts +v.
  Mat3 information = Mat3::Zero();
  for (size_t i = 0; i < n; ++i) {
    const Vec3 r = points[i] - centroid;
    const double height = r.dot(normal);
    const Vec3 row(1.0, r.dot(v), -r.dot(u));
    information.noalias() += weight(i) * row * row.transpose();
    fit.weighted_sum_of_squares += weight(i) * height * height;
  }
  fit.covariance.matrix = information.ldlt().solve(Mat3::Identity());
  fit.covariance.matrix = 0.5 * (fit.covariance.matrix + fit.covariance.matrix.transpose()).eval();
  return fit;
}

}  // namespace tetragauge
