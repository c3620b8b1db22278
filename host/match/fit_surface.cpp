// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/fit_surface.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

// How much a distance along the surface counts beside one across it: enough to bring a scan back that hangs
// over the model's edge, where no plane holds it, and little enough to let it slide into place.
constexpr double kAlong = 0.1;

class Pull {
 public:
  explicit Pull(const Vec3& pivot) : pivot_(pivot) {}

  // A point `at` of the part should move by -error; across `normal` in full.
  void add(const Vec3& at, const Vec3& error, const Vec3& normal, double weight) {
    const Vec3 arm = at - pivot_;
    Vec6 row;
    row << arm.cross(normal), normal;
    matrix_ += (weight * (1 - kAlong)) * row * row.transpose();
    right_ -= (weight * (1 - kAlong) * normal.dot(error)) * row;
    const double along = weight * kAlong;
    matrix_.topLeftCorner<3, 3>() += along * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
    Mat3 cross;
    cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
    matrix_.topRightCorner<3, 3>() += along * cross;
    matrix_.bottomLeftCorner<3, 3>() += along * cross.transpose();
    matrix_.bottomRightCorner<3, 3>() += along * Mat3::Identity();
    right_.head<3>() -= along * arm.cross(error);
    right_.tail<3>() -= along * error;
    total_ += weight;
  }

  RigidTransform moved(const RigidTransform& T, double size_mm) const {
    if (!(total_ > 0)) return T;
    Mat6 matrix = matrix_;
    const double little = 1e-6 * total_;
    matrix.diagonal().head<3>().array() += little * size_mm * size_mm;
    matrix.diagonal().tail<3>().array() += little;
    const Vec6 step = matrix.ldlt().solve(right_);
    const double angle = step.head<3>().norm();
    const Mat3 R =
        angle > 0 ? Eigen::AngleAxisd(angle, step.head<3>() / angle).toRotationMatrix() : Mat3::Identity();
    return RigidTransform{R, pivot_ + step.tail<3>() - R * pivot_} * T;
  }

 private:
  Vec3 pivot_;
  Mat6 matrix_ = Mat6::Zero();
  Vec6 right_ = Vec6::Zero();
  double total_ = 0;
};

// Distance from a sample without what the samples' spacing adds along the surface.
Vec3 beyond_spacing(const Vec3& error, const Vec3& normal, double spacing_mm) {
  const Vec3 across = normal * normal.dot(error);
  const Vec3 along = error - across;
  const double length = along.norm();
  return across + (length > spacing_mm ? along * (1 - spacing_mm / length) : Vec3(Vec3::Zero()));
}

double fade(double square, double scale_mm) {
  const double w = scale_mm * scale_mm / (scale_mm * scale_mm + square);
  return w * w;
}

}  // namespace

RigidTransform pull_to_surface(const SurfaceProblem& problem, const RigidTransform& start,
                               const PullOptions& options) {
  RigidTransform T = start;
  const size_t points = std::min(options.points, problem.points.size());
  std::vector<VisibleSample> visible;
  for (int k = 0; k < options.iterations; ++k) {
    const double share = options.iterations > 1 ? static_cast<double>(k) / (options.iterations - 1) : 1.0;
    const double scale = options.first_mm * std::pow(options.last_mm / options.first_mm, share);
    Pull pull(problem.pivot_mm);
    for (size_t i = 0; i < points; ++i) {
      const Vec3 p = T * problem.points[i].point_mm, towards = T.R * problem.points[i].towards;
      const SurfaceSample* near = problem.model.find(p, towards);
      if (!near) continue;
      const Vec3 error = beyond_spacing(p - near->point_mm, near->normal, problem.model_spacing_mm);
      pull.add(p, error, near->normal, fade(error.squaredNorm(), scale));
    }
    if (options.samples > 0) {
      if (k % 5 == 0) visible = visible_samples(problem, T, options.samples);
      double sum = 0;
      for (const VisibleSample& v : visible) sum += v.cosine;
      const RigidTransform back = T.inverse();
      for (const VisibleSample& v : visible) {
        const Vec3 at = v.sample->point_mm;
        const SurfaceSample* near = problem.scan.find(back * at, Vec3::Zero());
        const Vec3 p = T * near->point_mm;
        const Vec3 error = beyond_spacing(p - at, v.sample->normal, problem.scan_spacing_mm);
        pull.add(p, error, v.sample->normal,
                 fade(error.squaredNorm(), scale) * v.cosine * static_cast<double>(points) / sum);
      }
    }
    T = pull.moved(T, problem.size_mm);
  }
  return T;
}

SurfaceMisfit rough_misfit(const SurfaceProblem& problem, const RigidTransform& T, size_t points,
                           size_t samples, double scale_mm) {
  SurfaceMisfit misfit;
  points = std::min(points, problem.points.size());
  for (size_t i = 0; i < points; ++i) {
    const Vec3 p = T * problem.points[i].point_mm, towards = T.R * problem.points[i].towards;
    const SurfaceSample* near = problem.model.find(p, towards);
    double square = 1;
    if (near)
      square = beyond_spacing(p - near->point_mm, near->normal, problem.model_spacing_mm).squaredNorm() /
               (scale_mm * scale_mm);
    misfit.points += std::min(1.0, square) / static_cast<double>(points);
  }
  double sum = 0;
  const RigidTransform back = T.inverse();
  for (const VisibleSample& v : visible_samples(problem, T, samples)) {
    const Vec3 at = back * v.sample->point_mm;
    const double apart = (problem.scan.find(at, Vec3::Zero())->point_mm - at).norm();
    const double beyond = std::max(0.0, apart - problem.scan_spacing_mm) / scale_mm;
    misfit.samples += v.cosine * std::min(1.0, beyond * beyond);
    sum += v.cosine;
  }
  misfit.samples = sum > 0 ? misfit.samples / sum : 1;
  return misfit;
}

double median_distance(const SurfaceProblem& problem, const RigidTransform& T, size_t points) {
  std::vector<double> distances;
  for (size_t i = 0; i < std::min(points, problem.points.size()); ++i) {
    const Vec3 p = T * problem.points[i].point_mm;
    const SurfaceSample* near = problem.model.find(p, T.R * problem.points[i].towards);
    distances.push_back(near ? std::abs(near->normal.dot(p - near->point_mm)) : problem.size_mm);
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

}  // namespace tetragauge
