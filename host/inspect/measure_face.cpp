// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/measure_face.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "host/geometry/fit_plane.hpp"
#include "host/inspect/form.hpp"
#include "host/inspect/point_grid.hpp"

namespace tetragauge {
namespace {

using Row6 = Eigen::Matrix<double, 1, 6>;

double square(double x) {
  return x * x;
}

// Standard uncertainty that the pose gives to an offset along n at p (model frame).
double u_pose(const Match& match, const Vec3& p, const Vec3& n) {
  Row6 row;
  row << (p - match.centroid_mm).cross(n).transpose(), n.transpose();
  return std::sqrt(std::max(0.0, (row * match.covariance * row.transpose())(0)));
}

// Largest eigenvalue of the turn's covariance across the normal.
double pose_tilt_variance(const Match& match, const Vec3& n) {
  const Mat3 across = Mat3::Identity() - n * n.transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(across * match.covariance.topLeftCorner<3, 3>() * across);
  return std::max(0.0, eigen.eigenvalues()[2]);
}

// Points within three sigma or a quarter of a spacing of the face's edge hold light from both sides of it.
std::vector<uint32_t> away_from_edges(const FaceMeasurement& in, double spacing_mm) {
  std::vector<double> sigma;
  for (const uint32_t i : in.points) sigma.push_back(in.cast.sigma_mm[i]);
  std::nth_element(sigma.begin(), sigma.begin() + static_cast<std::ptrdiff_t>(sigma.size() / 2), sigma.end());
  const double margin = std::max(3 * sigma[sigma.size() / 2], 0.25 * spacing_mm);
  if (!(margin > 0)) return in.points;
  const std::vector<Vec3> edge = samples_along(in.outline, 0.5 * margin);
  const PointGrid grid(edge, margin);
  std::vector<uint32_t> kept;
  for (const uint32_t i : in.points) {
    // On the surface, so that a face out of place has its edge where its points are.
    const Vec3 p = in.face.type == SurfaceType::plane
                       ? Vec3(in.cast.points_mm[i] - in.cast.deviation_mm[i] * in.face.normal)
                       : in.cast.points_mm[i];
    if (!grid.any_within(p, margin)) kept.push_back(i);
  }
  return kept.size() >= 30 ? kept : in.points;
}

// What form is looked for against where the tolerance says nothing: five sigma.
double form_tolerance(const FaceMeasurement& in, double sigma) {
  return in.tolerance_mm > 0 ? in.tolerance_mm : std::max(1e-9, 5 * sigma);
}

void measure_plane(const FaceMeasurement& in, const std::vector<uint32_t>& points, const Match& match,
                   FaceInspection& out) {
  std::vector<Vec3> positions;
  std::vector<double> weights;
  for (const uint32_t i : points) {
    positions.push_back(in.cast.points_mm[i]);
    weights.push_back(1 / square(std::max(1e-6, in.cast.sigma_mm[i])));
  }
  const Vec3& n = in.face.normal;
  const std::optional<PlaneFit> fit = fit_plane(positions, weights, n);
  if (!fit) return;  // on a line: nothing is measured
  const double freedom = static_cast<double>(points.size()) - 3;
  // Residuals larger than sigma promises (form, roughness, an optimistic sigma) widen the uncertainty.
  const double inflate = freedom > 0 ? std::max(1.0, fit->weighted_sum_of_squares / freedom) : 1.0;
  const Mat3 covariance = inflate * fit->covariance.matrix;
  const auto height = [&](const Vec3& p) {
    return fit->normal.dot(fit->centroid_mm - p) / fit->normal.dot(n);
  };
  const auto own_variance = [&](const Vec3& p) {
    const Vec3 r = p - fit->centroid_mm;
    const Vec3 row(1, r.dot(fit->covariance.v), -r.dot(fit->covariance.u));
    return row.dot(covariance * row) + square(in.u_cal_mm);
  };
  out.measured = true;
  out.offset_mm = height(in.face.point_mm);
  out.u_offset_own_mm = std::sqrt(own_variance(in.face.point_mm));
  out.U_offset_mm = 2 * std::hypot(out.u_offset_own_mm, u_pose(match, in.face.point_mm, n));
  out.tilt_rad = std::atan2(fit->normal.cross(n).norm(), fit->normal.dot(n));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> tilt(covariance.bottomRightCorner<2, 2>());
  out.U_tilt_rad = 2 * std::sqrt(std::max(0.0, tilt.eigenvalues()[1]) + pose_tilt_variance(match, n));

  std::vector<Eigen::Vector2d> uv;
  std::vector<double> residual;
  double squares = 0, sigma = 0;
  for (size_t k = 0; k < points.size(); ++k) {
    const Vec3 r = positions[k] - fit->centroid_mm;
    uv.emplace_back(r.dot(fit->covariance.u), r.dot(fit->covariance.v));
    residual.push_back(r.dot(fit->normal));
    squares += square(residual.back());
    sigma += in.cast.sigma_mm[points[k]];
  }
  const double count = static_cast<double>(points.size());
  out.rms_mm = std::sqrt(squares / count);
  const Form form = form_deviation(uv, residual, form_tolerance(in, sigma / count));
  out.form_mm = form.form_mm;
  out.U_form_mm = form.U_mm;

  // Offset and tilt are worst at a corner of the face; half the form lies to either side of the fit.
  for (const Vec3& corner : in.outline.corners) {
    const double deviation = std::abs(height(corner)) + 0.5 * form.form_mm;
    const double U =
        std::hypot(2 * std::sqrt(own_variance(corner) + square(u_pose(match, corner, n))), 0.5 * form.U_mm);
    if (deviation + U <= out.profile_mm + out.U_profile_mm) continue;
    out.profile_mm = deviation;
    out.U_profile_mm = U;
  }
}

// Place on a curved surface, as arc and height along the axis where there is one.
Eigen::Vector2d place_on(const Face& face, const Vec3& p) {
  if (face.axis.isZero()) {
    const Vec3 r = p - face.point_mm;
    return {r.x(), r.y()};
  }
  const auto [u, v] = tangent_frame(face.axis);
  const Vec3 r = p - face.point_on_axis_mm;
  const double x = r.dot(u), y = r.dot(v);
  return {std::hypot(x, y) * std::atan2(y, x), r.dot(face.axis)};
}

// Curved faces are compared point by point with the model's surface.
void measure_curved(const FaceMeasurement& in, const std::vector<uint32_t>& points, const Match& match,
                    FaceInspection& out) {
  double total = 0, mean = 0, chi2 = 0, squares = 0, sigma = 0;
  for (const uint32_t i : points) {
    const double weight = 1 / square(std::max(1e-6, in.cast.sigma_mm[i]));
    total += weight;
    mean += weight * in.cast.deviation_mm[i];
  }
  mean /= total;
  std::vector<Eigen::Vector2d> uv;
  std::vector<double> residual;
  for (const uint32_t i : points) {
    residual.push_back(in.cast.deviation_mm[i] - mean);
    uv.push_back(place_on(in.face, in.cast.points_mm[i]));
    chi2 += square(residual.back() / std::max(1e-6, in.cast.sigma_mm[i]));
    squares += square(residual.back());
    sigma += in.cast.sigma_mm[i];
  }
  const double count = static_cast<double>(points.size());
  const double inflate = count > 1 ? std::max(1.0, chi2 / (count - 1)) : 1.0;
  double pose_variance = 0;
  for (int k = 0; k < 3; ++k)
    pose_variance = std::max(pose_variance, square(u_pose(match, in.face.point_mm, Vec3::Unit(k))));
  out.measured = true;
  out.offset_mm = mean;
  out.u_offset_own_mm = std::sqrt(inflate / total + square(in.u_cal_mm));
  out.U_offset_mm = 2 * std::sqrt(square(out.u_offset_own_mm) + pose_variance);
  out.rms_mm = std::sqrt(squares / count);
  const Form form = form_deviation(uv, residual, form_tolerance(in, sigma / count));
  out.form_mm = form.form_mm;
  out.U_form_mm = form.U_mm;
  out.profile_mm = std::abs(mean) + 0.5 * form.form_mm;
  out.U_profile_mm = std::hypot(out.U_offset_mm, 0.5 * form.U_mm);
}

}  // namespace

double coverage(const FaceMeasurement& in, double spacing_mm) {
  if (in.points.empty() || !(spacing_mm > 0)) return 0;
  std::vector<Vec3> points;
  for (const uint32_t i : in.points) {
    Vec3 p = in.cast.points_mm[i];
    if (in.face.type == SurfaceType::plane) p -= in.cast.deviation_mm[i] * in.face.normal;
    points.push_back(p);
  }
  const double near = 1.5 * spacing_mm;
  const PointGrid grid(points, near);
  const std::vector<Vec3> samples = samples_over(in.outline, 1000);
  const auto covered =
      std::count_if(samples.begin(), samples.end(), [&](const Vec3& p) { return grid.any_within(p, near); });
  return samples.empty() ? 0 : static_cast<double>(covered) / static_cast<double>(samples.size());
}

void measure_face(const FaceMeasurement& in, const Match& match, FaceInspection& out) {
  const double area =
      in.measured_area_mm2 > 0 ? std::min(in.measured_area_mm2, in.face.area_mm2) : in.face.area_mm2;
  const double spacing = std::sqrt(area / static_cast<double>(in.points.size()));
  out.coverage = coverage(in, spacing);
  out.measured_area_mm2 = in.measured_area_mm2 > 0 ? area : out.coverage * in.face.area_mm2;
  const std::vector<uint32_t> points = away_from_edges(in, spacing);
  out.points_used = points.size();
  out.points_rejected += in.points.size() - points.size();
  if (in.face.type == SurfaceType::plane) {
    measure_plane(in, points, match, out);
  } else {
    measure_curved(in, points, match, out);
  }
}

}  // namespace tetragauge
