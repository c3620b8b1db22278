// SPDX-License-Identifier: GPL-3.0-or-later
// Curved faces against the model's surface, point by point; where the surface is analytic also as the small
// motion and growth that best explain the deviations.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "host/inspect/applies_to.hpp"
#include "host/inspect/measure_face.hpp"
#include "host/solid/surface_crossings.hpp"

namespace tetragauge {
namespace {

using Vec7 = CurveAsMeasured::Vec7;
using Mat7 = CurveAsMeasured::Mat7;
using Row7 = Eigen::Matrix<double, 1, 7>;

// A direction of motion that moves the surface less than this share of what others do is not felt: the
// spread of normals within a face is far above it, rounding far below.
constexpr double kUnfelt = 1e-10;

double weight_of(double sigma_mm) {
  const double sigma = std::max(1e-6, sigma_mm);
  return 1 / (sigma * sigma);
}

Row7 row_at(const Vec3& p, const Vec3& n, const Vec3& pivot) {
  Row7 row;
  row << (p - pivot).cross(n).transpose(), n.transpose(), 1;
  return row;
}

// Along the axis to the middle of the points; elsewhere the centre, or the points' own middle.
Vec3 pivot_of(const FaceMeasurement& in, const Vec3& middle) {
  if (has_axis(in.face))
    return in.face.point_on_axis_mm + in.face.axis * in.face.axis.dot(middle - in.face.point_on_axis_mm);
  return has_crossings(in.face) ? in.face.point_on_axis_mm : middle;
}

// Place on the surface, as arc and height along the axis where it unrolls.
Vec3 place_on(const Face& face, const Vec3& p) {
  if (!has_axis(face)) return p;
  const auto [u, v] = tangent_frame(face.axis);
  const Vec3 r = p - face.point_on_axis_mm;
  const double x = r.dot(u), y = r.dot(v);
  return {std::hypot(x, y) * std::atan2(y, x), r.dot(face.axis), 0};
}

double area_of(const FaceMeasurement& in, std::span<const Vec3> place, double measured_area_mm2) {
  if (!has_axis(in.face)) return measured_area_mm2;
  Vec3 low = place[0], high = place[0];
  for (const Vec3& p : place) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high.x() - low.x()) * (high.y() - low.y());
}

Mat3 turn_by(const Vec3& turn_rad) {
  const double angle = turn_rad.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix() : Mat3::Identity();
}

// The model's surface moved and grown; p as seen from there lies at `unmoved`.
struct Moved {
  Mat3 turn;
  Vec3 about, shift;
  double growth;

  Moved(const Vec3& pivot, const Vec7& motion)
      : turn(turn_by(motion.head<3>())), about(pivot), shift(motion.segment<3>(3)), growth(motion[6]) {}
  Vec3 unmoved(const Vec3& p) const { return about + turn.transpose() * (p - about - shift); }
  double deviation(const Face& face, const Vec3& p) const {
    return distance_to_surface(face, unmoved(p)) - growth;
  }
  Row7 row(const Face& face, const Vec3& p) const {
    return row_at(p, turn * surface_normal(face, unmoved(p)), about + shift);
  }
};

constexpr int kMostSteps = 20;
constexpr double kSettled_mm = 1e-9;

// By Gauss and Newton: a bore out of place by a tenth of its radius is no thousandth of it narrower, as one
// linear step would have it. Nothing for a surface without normals of its own (free-form).
CurveAsMeasured fit_motion(const FaceMeasurement& in, const Vec3& pivot) {
  CurveAsMeasured fit;
  fit.pivot_mm = pivot;
  double arm = 0;
  for (const uint32_t i : in.points) arm = std::max(arm, (in.cast.points_mm[i] - pivot).norm());
  if (!(arm > 0)) return fit;
  Vec7 unit = Vec7::Ones();  // turns by the arc they make
  unit.head<3>().setConstant(1 / arm);
  double chi2 = 0;
  int felt = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const Moved moved(pivot, fit.motion);
    Mat7 normal = Mat7::Zero();
    Vec7 right = Vec7::Zero();
    chi2 = 0;
    for (const uint32_t i : in.points) {
      const Row7 row = moved.row(in.face, in.cast.points_mm[i]) * unit.asDiagonal();
      const double weight = weight_of(in.cast.sigma_mm[i]);
      const double deviation = moved.deviation(in.face, in.cast.points_mm[i]);
      normal += weight * row.transpose() * row;
      right += weight * deviation * row.transpose();
      chi2 += weight * deviation * deviation;
    }
    const Eigen::SelfAdjointEigenSolver<Mat7> eigen(normal);
    Vec7 inverse = Vec7::Zero();
    felt = 0;
    for (int k = 0; k < 7; ++k) {
      if (!(eigen.eigenvalues()[k] > kUnfelt * eigen.eigenvalues()[6])) continue;
      inverse[k] = 1 / eigen.eigenvalues()[k];
      ++felt;
    }
    const Mat7 solve = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
    fit.covariance = unit.asDiagonal() * solve * unit.asDiagonal();
    const Vec7 change = solve * right;
    if (step > 0 && change.norm() < kSettled_mm) break;
    fit.motion += unit.asDiagonal() * change;
  }
  fit.covariance *= inflation(chi2, static_cast<double>(in.points.size()) - felt);
  return fit;
}

// How far the axis (or the centre) lies from its place, where that is most, in the part's pose.
void measure_position(const FaceMeasurement& in, FaceInspection& out) {
  const Vec3& pivot = out.curve->pivot_mm;
  std::vector<Vec3> places{pivot};
  Mat3 across = Mat3::Identity();
  if (in.face.type == SurfaceType::cylinder) {
    const Vec3& axis = in.face.axis;
    across -= axis * axis.transpose();
    double low = 1e300, high = -1e300;
    for (const Vec3& corner : in.outline.corners) {
      low = std::min(low, axis.dot(corner - pivot));
      high = std::max(high, axis.dot(corner - pivot));
    }
    places = {pivot + low * axis, pivot + high * axis};
  }
  double most = -1;
  for (const Vec3& place : places) {
    const auto rows = [&](const Vec3& about) {
      const Vec3 r = place - about;
      Mat36 J;
      J.col(0) = Vec3::UnitX().cross(r);
      J.col(1) = Vec3::UnitY().cross(r);
      J.col(2) = Vec3::UnitZ().cross(r);
      J.rightCols<3>().setIdentity();
      return Mat36(across * J);
    };
    const Mat36 own = rows(pivot), of_pose = rows(in.pose.pivot_mm);
    const double shift = (own * out.curve->motion.head<6>()).norm();
    const Mat3 covariance = own * out.curve->covariance.topLeftCorner<6, 6>() * own.transpose() +
                            of_pose * in.pose.covariance * of_pose.transpose();
    const double u2 = Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvalues()[2];
    const double U = 2 * std::sqrt(std::max(0.0, u2));
    if (shift + U <= most) continue;
    most = shift + U;
    out.position_mm = shift;
    out.U_position_mm = U;
  }
}

struct Mean {
  double value_mm = 0, own_variance = 0;
  Row6 of_pose = Row6::Zero();
};

Mean mean_deviation(const FaceMeasurement& in, bool has_normals) {
  Mean mean;
  double total = 0, chi2 = 0;
  for (const uint32_t i : in.points) {
    const double weight = weight_of(in.cast.sigma_mm[i]);
    total += weight;
    mean.value_mm += weight * in.cast.deviation_mm[i];
    const Vec3& p = in.cast.points_mm[i];
    if (has_normals) mean.of_pose += weight * offset_row(p, surface_normal(in.face, p), in.pose.pivot_mm);
  }
  mean.value_mm /= total;
  mean.of_pose /= total;
  for (const uint32_t i : in.points) {
    const double residual = in.cast.deviation_mm[i] - mean.value_mm;
    chi2 += weight_of(in.cast.sigma_mm[i]) * residual * residual;
  }
  mean.own_variance = inflation(chi2, static_cast<double>(in.points.size()) - 1) / total;
  return mean;
}

}  // namespace

double deviation_as_measured(const Face& face, const FaceInspection& measured, const Vec3& point_mm,
                             double deviation_mm) {
  if (!measured.measured) return deviation_mm;
  if (measured.curve)
    return Moved(measured.curve->pivot_mm, measured.curve->motion).deviation(face, point_mm);
  return deviation_mm - measured.offset_mm;
}

void measure_curve(const FaceMeasurement& in, FaceInspection& out) {
  const bool has_normals = has_crossings(in.face);
  const auto square = [](double x) { return x * x; };
  const auto pose_variance = [&](const Row6& row) {
    return std::max(0.0, (row * in.pose.covariance * row.transpose())(0));
  };
  // The worst way the pose can move the face: what stands in for its normals where it has none.
  double any_direction = 0;
  for (int k = 0; k < 3; ++k)
    any_direction =
        std::max(any_direction, pose_variance(offset_row(in.face.point_mm, Vec3::Unit(k), in.pose.pivot_mm)));

  const Mean mean = mean_deviation(in, has_normals);
  out.measured = true;
  out.offset_mm = mean.value_mm;
  out.u_offset_own_mm = std::sqrt(mean.own_variance + square(in.u_cal_mm));
  out.U_offset_mm = 2 * std::sqrt(square(out.u_offset_own_mm) +
                                  (has_normals ? pose_variance(mean.of_pose) : any_direction));

  Vec3 middle = Vec3::Zero();
  for (const uint32_t i : in.points) middle += in.cast.points_mm[i] / static_cast<double>(in.points.size());
  const Vec3 pivot = pivot_of(in, middle);
  if (has_normals) {
    out.curve = fit_motion(in, pivot);
    for (int k = 3; k < 7; ++k)
      if (out.curve->covariance(k, k) > 0) out.curve->covariance(k, k) += square(in.u_cal_mm);
    if (in.face.type == SurfaceType::cylinder || in.face.type == SurfaceType::sphere) {
      out.radius_mm = in.face.concave ? -out.curve->motion[6] : out.curve->motion[6];
      out.U_radius_mm = 2 * std::sqrt(out.curve->covariance(6, 6));
      measure_position(in, out);
    }
  }
  std::vector<Vec3> place;
  std::vector<double> residual;
  for (const uint32_t i : in.points) {
    const Vec3& p = in.cast.points_mm[i];
    place.push_back(place_on(in.face, p));
    residual.push_back(has_normals ? Moved(pivot, out.curve->motion).deviation(in.face, p)
                                   : in.cast.deviation_mm[i] - mean.value_mm);
  }
  measure_residuals(in, place, residual, area_of(in, place, out.measured_area_mm2), out);

  if (!has_normals) {
    out.profile_mm = std::abs(out.offset_mm) + 0.5 * out.form_mm;
    out.U_profile_mm = std::hypot(out.U_offset_mm, 0.5 * out.U_form_mm);
    return;
  }
  for (const Vec3& corner : in.outline.corners) {
    const Vec3 n = surface_normal(in.face, corner);
    const Row7 row = row_at(corner, n, pivot);
    const double deviation = std::abs((row * out.curve->motion)(0)) + 0.5 * out.form_mm;
    const double own = (row * out.curve->covariance * row.transpose())(0);
    const double u2 = std::max(0.0, own) + pose_variance(offset_row(corner, n, in.pose.pivot_mm));
    const double U = std::hypot(2 * std::sqrt(u2), 0.5 * out.U_form_mm);
    if (deviation + U <= out.profile_mm + out.U_profile_mm) continue;
    out.profile_mm = deviation;
    out.U_profile_mm = U;
  }
}

}  // namespace tetragauge
