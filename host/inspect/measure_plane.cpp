// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "host/geometry/fit_plane_along_rays.hpp"
#include "host/inspect/measure_face.hpp"
#include "host/inspect/plane_deviation.hpp"

namespace tetragauge {
namespace {

// Standard uncertainties of a plane face's offset and tilt in the part's pose.
class Uncertainty {
 public:
  Uncertainty(const PlaneAsMeasured& plane, const Vec3& normal, const PoseError& pose)
      : plane_(plane), normal_(normal), pose_(pose) {}

  double offset(const Vec3& p) const {
    const Row6 of_pose = offset_row(p, normal_, pose_.pivot_mm);
    const Eigen::RowVector3d own = height_row(plane_, p) + of_pose * pose_.own_gain;
    return std::sqrt(std::max(0.0, (own * plane_.covariance.matrix * own.transpose() +
                                    of_pose * pose_.covariance * of_pose.transpose())(0)));
  }

  double tilt() const {
    const Eigen::Matrix<double, 2, 6> of_pose = tilt_rows(plane_.covariance.u, plane_.covariance.v);
    Eigen::Matrix<double, 2, 3> own = of_pose * pose_.own_gain;
    own.rightCols<2>() += Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d total =
        own * plane_.covariance.matrix * own.transpose() + of_pose * pose_.covariance * of_pose.transpose();
    return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(total).eigenvalues()[1]));
  }

 private:
  const PlaneAsMeasured& plane_;
  const Vec3& normal_;
  const PoseError& pose_;
};

}  // namespace

std::optional<PlaneFit> fit_along_rays(const FaceMeasurement& in) {
  std::vector<Vec3> points, directions;
  std::vector<double> weights;
  for (const uint32_t i : in.points) {
    const double sigma = std::max(1e-6, in.cast.sigma_mm[i]);
    points.push_back(in.cast.points_mm[i]);
    directions.push_back(in.cast.direction[i]);
    weights.push_back(1 / (sigma * sigma));
  }
  return fit_plane_along_rays(points, directions, weights, in.face.normal);
}

void measure_plane(const FaceMeasurement& in, FaceInspection& out) {
  const Vec3& n = in.face.normal;
  const std::optional<PlaneFit> fit = fit_along_rays(in);
  if (!fit) return;  // on a line: nothing is measured
  PlaneAsMeasured plane{fit->normal, fit->centroid_mm, fit->covariance};
  plane.covariance.matrix *=
      inflation(fit->weighted_sum_of_squares, static_cast<double>(in.points.size()) - 3);
  plane.covariance.matrix(0, 0) += in.u_cal_mm * in.u_cal_mm;

  out.measured = true;
  out.plane = plane;
  const Uncertainty u(plane, n, in.pose);
  const Vec3& centre = in.face.point_mm;
  out.offset_mm = height(plane, n, centre);
  out.u_offset_own_mm = std::sqrt(own_height_variance(plane, centre));
  out.U_offset_mm = 2 * u.offset(centre);
  out.tilt_rad = std::atan2(fit->normal.cross(n).norm(), fit->normal.dot(n));
  out.U_tilt_rad = 2 * u.tilt();

  std::vector<Vec3> place;
  std::vector<double> residual;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
  for (const uint32_t i : in.points) {
    const Vec3& p = in.cast.points_mm[i];
    const Vec3 r = meet_plane(p, in.cast.direction[i], fit->normal, fit->centroid_mm) - fit->centroid_mm;
    const Eigen::Vector2d uv(r.dot(fit->covariance.u), r.dot(fit->covariance.v));
    low = low.cwiseMin(uv);
    high = high.cwiseMax(uv);
    place.emplace_back(uv.x(), uv.y(), 0);
    residual.push_back((p - fit->centroid_mm).dot(fit->normal));
  }
  measure_residuals(in, place, residual, (high - low).prod(), out);

  // Offset and tilt are worst at a corner of the face; half the form lies to either side of the fit.
  for (const Vec3& corner : in.outline.corners) {
    const double deviation = std::abs(height(plane, n, corner)) + 0.5 * out.form_mm;
    const double U = std::hypot(2 * u.offset(corner), 0.5 * out.U_form_mm);
    if (deviation + U <= out.profile_mm + out.U_profile_mm) continue;
    out.profile_mm = deviation;
    out.U_profile_mm = U;
  }
}

}  // namespace tetragauge
