// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/compare_planes.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tetragauge {

PlaneCovariance covariance_at(const PlaneFit& fit, const Vec3& point) {
  PlaneCovariance moved = fit.covariance;
  const Vec3 r = point - fit.centroid_mm;
  Mat3 J = Mat3::Identity();  // offset at the point = offset + tilt_u (r . v) - tilt_v (r . u)
  J(0, 1) = r.dot(moved.v);
  J(0, 2) = -r.dot(moved.u);
  moved.matrix = J * moved.matrix * J.transpose();
  moved.matrix = 0.5 * (moved.matrix + moved.matrix.transpose()).eval();
  return moved;
}

double noise_scale(const PlaneFit& fit) {
  if (fit.points <= 3) return 1;
  return std::clamp(std::sqrt(fit.weighted_sum_of_squares / static_cast<double>(fit.points - 3)), 1.0, 3.0);
}

double plane_chi2(const PlaneFit& a, const PlaneFit& b) {
  const Vec3 middle = 0.5 * (a.centroid_mm + b.centroid_mm);
  const PlaneCovariance of_a = covariance_at(a, middle), of_b = covariance_at(b, middle);
  Mat3 to_a = Mat3::Identity();  // tilts about b's axes to tilts about a's
  to_a(1, 1) = of_a.u.dot(of_b.u);
  to_a(1, 2) = of_a.u.dot(of_b.v);
  to_a(2, 1) = of_a.v.dot(of_b.u);
  to_a(2, 2) = of_a.v.dot(of_b.v);
  const Mat3 covariance = std::pow(noise_scale(a), 2) * of_a.matrix +
                          std::pow(noise_scale(b), 2) * (to_a * of_b.matrix * to_a.transpose());
  const Vec3 turn = a.normal.cross(b.normal);
  const Vec3 difference((b.d_mm - b.normal.dot(middle)) - (a.d_mm - a.normal.dot(middle)), turn.dot(of_a.u),
                        turn.dot(of_a.v));
  return difference.dot(covariance.ldlt().solve(difference));
}

}  // namespace tetragauge
