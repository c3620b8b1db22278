// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/polish_on_surface.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "host/match/faces_out.hpp"

namespace tetragauge {
namespace {

constexpr double kTukey = 4.685;  // 95 % efficient (Holland and Welsch, Commun. Stat. A6 (1977) 813)
constexpr size_t kCostPoints = 1500, kCostSamples = 800;

}  // namespace

RigidTransform nudged(const RigidTransform& T, const Vec6& step, const Vec3& pivot) {
  const double angle = step.head<3>().norm();
  const Mat3 R =
      angle > 0 ? Eigen::AngleAxisd(angle, step.head<3>() / angle).toRotationMatrix() : Mat3::Identity();
  return RigidTransform{R, pivot + step.tail<3>() - R * pivot} * T;
}

namespace {

// Of a part of the points: of the many that err together it holds so many less.
SurfaceScatter scatter_of_part(const SurfaceProblem& problem, const SurfaceScatter& scatter, size_t count) {
  const double share = static_cast<double>(count) / static_cast<double>(problem.points.size());
  return {scatter.scatter_mm, std::max(1.0, share * scatter.together)};
}

// Of the points, then of the model's samples.
std::vector<double> costs_of(const SurfaceProblem& problem, const RigidTransform& T,
                             const std::vector<RayResidual>& residuals, const SurfaceScatter& scatter) {
  const auto count = static_cast<double>(residuals.size());
  const double together = scatter.together;
  const double added = scatter.scatter_mm * scatter.scatter_mm;
  std::vector<double> costs;
  for (const RayResidual& r : residuals)
    costs.push_back((r.near ? std::min(kMostSurprise, r.offset_mm * r.offset_mm / (r.variance_mm2 + added))
                            : kMostSurprise) /
                    together);
  costs.resize(residuals.size() + std::min(kCostSamples, problem.model.samples().size()), 0.0);
  const double blur_mm = std::hypot(scatter.scatter_mm, problem.scan_spacing_mm);
  const RigidTransform back = T.inverse();
  const std::vector<VisibleSample> visible = visible_samples(problem, T, kCostSamples);
  double weight = 0;
  for (const VisibleSample& v : visible) weight += v.cosine;
  for (const VisibleSample& v : visible) {
    const Vec3 at = back * v.sample->point_mm;
    const double apart = (problem.scan.find(at, Vec3::Zero())->point_mm - at).norm();
    const double beyond = std::max(0.0, apart - problem.scan_spacing_mm) / blur_mm;
    // All that could be seen count together as much as all points.
    costs[residuals.size() + static_cast<size_t>(v.sample - problem.model.samples().data())] =
        v.cosine * std::min(kMostSurprise, beyond * beyond) * count / weight / together;
  }
  return costs;
}

}  // namespace

std::vector<double> surface_costs(const SurfaceProblem& problem, const RigidTransform& T,
                                  const SurfaceScatter& scatter) {
  const std::vector<RayResidual> residuals = ray_residuals(problem, T, kCostPoints);
  return costs_of(problem, T, residuals, scatter_of_part(problem, scatter, residuals.size()));
}

double surface_cost(const SurfaceProblem& problem, const RigidTransform& T, const SurfaceScatter& scatter) {
  const std::vector<double> costs = surface_costs(problem, T, scatter);
  return std::accumulate(costs.begin(), costs.end(), 0.0);
}

double cost_as_made(const SurfaceProblem& problem, const RigidTransform& T, const SurfaceScatter& scatter,
                    double most_out_mm) {
  std::vector<RayResidual> residuals = ray_residuals(problem, T, kCostPoints);
  const SurfaceScatter of_part = scatter_of_part(problem, scatter, residuals.size());
  const std::vector<double> in_place = costs_of(problem, T, residuals, of_part);
  const std::map<int, double> out = faces_out(residuals, of_part, most_out_mm);
  for (RayResidual& r : residuals) r.offset_mm = offset_as_made(r, out);
  const std::vector<double> as_made = costs_of(problem, T, residuals, of_part);
  double cost = kMostSurprise * static_cast<double>(out.size());
  for (size_t i = 0; i < in_place.size(); ++i) cost += in_place[i] + as_made[i];
  return 0.5 * cost;
}

namespace {

struct Sums {
  Vec6 row = Vec6::Zero();
  double weight = 0, offset = 0;
};

PolishedPose polish(const SurfaceProblem& problem, const RigidTransform& start, const SurfaceScatter& scatter,
                    size_t points, int iterations, const Vec6& held, double most_out_mm) {
  PolishedPose out{start};
  const Vec3& pivot = problem.pivot_mm;
  const double arm_mm = 0.3 * problem.size_mm, added = scatter.scatter_mm * scatter.scatter_mm;
  Vec6 hold;  // the outlines' own information
  hold << Vec3::Constant(arm_mm * arm_mm), Vec3::Ones();
  hold /= problem.scan_spacing_mm * problem.scan_spacing_mm;
  Vec6 gone = Vec6::Zero();  // from the start, summed up
  for (int k = 0; k <= iterations; ++k) {
    Mat6 matrix = Mat6::Zero();
    Vec6 right = Vec6::Zero();
    double squares = 0, used = 0;
    const std::vector<RayResidual> residuals = ray_residuals(problem, out.T_model_part, points);
    const std::map<int, double> off =
        most_out_mm > 0 ? faces_out(residuals, scatter, most_out_mm) : std::map<int, double>{};
    std::map<int, Sums> grown;
    for (const RayResidual& r : residuals) {
      if (!r.near) continue;
      const double rest = offset_as_made(r, off);
      const double square = rest * rest / (r.variance_mm2 + added) / (kTukey * kTukey);
      if (square >= 1) continue;
      const double weight = (1 - square) * (1 - square) / (r.variance_mm2 + added);
      Vec6 row;
      row << (r.foot_mm - pivot).cross(r.normal), r.normal;
      matrix += weight * row * row.transpose();
      right -= weight * r.offset_mm * row;
      squares += rest * rest;
      used += 1;
      if (!off.contains(r.face)) continue;
      Sums& sums = grown[r.face];
      sums.row += weight * row;
      sums.weight += weight;
      sums.offset += weight * r.offset_mm;
    }
    // The growth of each, known beforehand to be about that large, is solved for and left out (Schur).
    for (const auto& [face, sums] : grown) {
      const double pivot_weight = sums.weight + scatter.together / (off.at(face) * off.at(face));
      matrix -= sums.row * sums.row.transpose() / pivot_weight;
      right += sums.offset / pivot_weight * sums.row;
    }
    out.information = matrix / scatter.together;
    out.rms_mm = used > 0 ? std::sqrt(squares / used) : 0;
    if (k == iterations) break;
    matrix.diagonal() += hold;
    // So stiff that what gives way is far below what matters, and the equations stay solvable.
    matrix += 1e4 * matrix.diagonal().tail<3>().sum() * held * held.transpose();
    right -= hold.cwiseProduct(gone);
    const Vec6 step = matrix.ldlt().solve(right);
    gone += step;
    out.T_model_part = nudged(out.T_model_part, step, pivot);
    if (arm_mm * step.head<3>().norm() + step.tail<3>().norm() < 1e-7 * problem.size_mm) {
      iterations = k + 1;
    }
  }
  return out;
}

}  // namespace

PolishedPose polish_on_surface(const SurfaceProblem& problem, const RigidTransform& start,
                               const SurfaceScatter& scatter, size_t points, int iterations,
                               const Vec6& held) {
  return polish(problem, start, scatter, points, iterations, held, 0);
}

PolishedPose polish_with_faces_out(const SurfaceProblem& problem, const RigidTransform& start,
                                   const SurfaceScatter& scatter, size_t points, int iterations,
                                   double most_out_mm) {
  return polish(problem, start, scatter, points, iterations, Vec6::Zero(), most_out_mm);
}

}  // namespace tetragauge
