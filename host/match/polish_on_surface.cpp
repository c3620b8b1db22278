// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/polish_on_surface.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace tetragauge {
namespace {

constexpr double kLeastCosine = 0.1;  // beyond 84 degrees of incidence a range says little about the surface
constexpr double kMostSurprise = 9;   // three standard deviations, squared
constexpr double kTukey = 4.685;      // 95 % efficient (Holland and Welsch, Commun. Stat. A6 (1977) 813)
constexpr double kFromMedian = 1.4826;  // standard deviation from a median of absolute values
constexpr size_t kCostPoints = 1500, kCostSamples = 800;
constexpr double kLeastOfFace = 30;  // points, to tell whether it is out of place
constexpr int kBlocks = 8;           // along the model's size: waves within such a block err together

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

RigidTransform nudged(const RigidTransform& T, const Vec6& step, const Vec3& pivot) {
  const double angle = step.head<3>().norm();
  const Mat3 R =
      angle > 0 ? Eigen::AngleAxisd(angle, step.head<3>() / angle).toRotationMatrix() : Mat3::Identity();
  return RigidTransform{R, pivot + step.tail<3>() - R * pivot} * T;
}

std::vector<RayResidual> ray_residuals(const SurfaceProblem& problem, const RigidTransform& T,
                                       size_t points) {
  std::vector<RayResidual> residuals(std::min(points, problem.points.size()));
  const double reach_mm = 2 * problem.size_mm;  // the ray is followed from so far before the point
  for (size_t i = 0; i < residuals.size(); ++i) {
    RayResidual& out = residuals[i];
    const Vec3 p = T * problem.points[i].point_mm, towards = T.R * problem.points[i].towards;
    out.point_mm = p;
    double distance = problem.size_mm;  // for choosing between the two: how far the point is off at all
    if (const SurfaceSample* sample = problem.model.find(p, towards)) {
      const Vec3 error = p - sample->point_mm;
      const double across = sample->normal.dot(error);
      const double along = (error - across * sample->normal).norm();
      if (along < 1.5 * problem.model_spacing_mm) {
        out = {true, across, 0, p, sample->normal, -1};
        distance = std::abs(across);
      }
    }
    const double before = std::min(reach_mm, problem.points[i].range_mm);
    const std::optional<RayHit> hit = problem.caster.first_hit(p + before * towards, -towards);
    if (hit) {
      const double across = hit->normal.dot(p - hit->point_mm);
      // The hit is exact where the sample is not; it is left only where the ray meets something else.
      if (std::abs(across) < distance + 0.25 * problem.model_spacing_mm &&
          std::abs(hit->distance_mm - before) < 3 * problem.model_spacing_mm + 4 * std::abs(across))
        out = {true, across, 0, p, hit->normal, hit->face};
    }
    if (!out.near) continue;
    const double cosine = std::max(kLeastCosine, std::abs(out.normal.dot(towards)));
    out.variance_mm2 = std::pow(problem.points[i].sigma_mm * cosine, 2);
  }
  return residuals;
}

double scatter_about_surface(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals) {
  std::vector<double> offsets;
  for (const RayResidual& r : residuals) offsets.push_back(r.near ? std::abs(r.offset_mm) : problem.size_mm);
  return kFromMedian * median(std::move(offsets));
}

SurfaceScatter surface_scatter(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals) {
  SurfaceScatter scatter;
  if (residuals.empty()) return scatter;
  std::vector<double> own;
  for (const RayResidual& r : residuals) own.push_back(r.variance_mm2);
  const double all = scatter_about_surface(problem, residuals), sensor = median(std::move(own));
  scatter.scatter_mm = std::sqrt(std::max(1e-10 * problem.size_mm * problem.size_mm, all * all - sensor));

  // Sums over blocks scatter more than independent points' would by the number that err together (batch
  // means).
  std::map<std::array<int, 3>, double> sums;
  double squares = 0;
  const double block_mm = problem.size_mm / kBlocks;
  for (const RayResidual& r : residuals) {
    const double normalised =
        r.offset_mm / std::sqrt(r.variance_mm2 + scatter.scatter_mm * scatter.scatter_mm);
    if (!r.near || normalised * normalised > kMostSurprise) continue;
    const Vec3 at = r.point_mm / block_mm;
    sums[{static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())),
          static_cast<int>(std::floor(at.z()))}] += normalised;
    squares += normalised * normalised;
  }
  double of_sums = 0;
  for (const auto& [block, sum] : sums) of_sums += sum * sum;
  if (squares > 0) scatter.together = std::max(1.0, of_sums / squares);
  return scatter;
}

std::vector<double> surface_costs(const SurfaceProblem& problem, const RigidTransform& T,
                                  const SurfaceScatter& scatter) {
  const std::vector<RayResidual> residuals = ray_residuals(problem, T, kCostPoints);
  const auto count = static_cast<double>(residuals.size());
  const double together =
      std::max(1.0, scatter.together * count / static_cast<double>(problem.points.size()));
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

double surface_cost(const SurfaceProblem& problem, const RigidTransform& T, const SurfaceScatter& scatter) {
  const std::vector<double> costs = surface_costs(problem, T, scatter);
  return std::accumulate(costs.begin(), costs.end(), 0.0);
}

namespace {

// By how much each face as a whole lies off its place, as far as that is no chance.
std::map<int, double> faces_out(const std::vector<RayResidual>& residuals, const SurfaceScatter& scatter) {
  std::map<int, std::vector<double>> offsets;
  std::map<int, double> variance;
  for (const RayResidual& r : residuals) {
    if (!r.near || r.face < 0) continue;
    offsets[r.face].push_back(r.offset_mm);
    variance[r.face] += r.variance_mm2 + scatter.scatter_mm * scatter.scatter_mm;
  }
  std::map<int, double> out;
  for (auto& [face, of_face] : offsets) {
    const auto count = static_cast<double>(of_face.size());
    if (count < kLeastOfFace) continue;
    // A median of normal errors scatters pi / 2 times as much, squared, as their mean.
    const double chance = 0.5 * std::numbers::pi * scatter.together * variance[face] / (count * count);
    const double off = median(std::move(of_face));
    if (off * off > kMostSurprise * chance) out[face] = off;
  }
  return out;
}

struct Sums {
  Vec6 row = Vec6::Zero();
  double weight = 0, offset = 0;
};

PolishedPose polish(const SurfaceProblem& problem, const RigidTransform& start, const SurfaceScatter& scatter,
                    size_t points, int iterations, const Vec6& held, bool with_faces_out) {
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
        with_faces_out ? faces_out(residuals, scatter) : std::map<int, double>{};
    std::map<int, Sums> grown;
    for (const RayResidual& r : residuals) {
      if (!r.near) continue;
      const auto face = off.find(r.face);
      const double rest = r.offset_mm - (face == off.end() ? 0 : face->second);
      const double square = rest * rest / (r.variance_mm2 + added) / (kTukey * kTukey);
      if (square >= 1) continue;
      const double weight = (1 - square) * (1 - square) / (r.variance_mm2 + added);
      Vec6 row;
      row << (r.point_mm - pivot).cross(r.normal), r.normal;
      matrix += weight * row * row.transpose();
      right -= weight * r.offset_mm * row;
      squares += rest * rest;
      used += 1;
      if (face == off.end()) continue;
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
  return polish(problem, start, scatter, points, iterations, held, false);
}

PolishedPose polish_with_faces_out(const SurfaceProblem& problem, const RigidTransform& start,
                                   const SurfaceScatter& scatter, size_t points, int iterations) {
  return polish(problem, start, scatter, points, iterations, Vec6::Zero(), true);
}

}  // namespace tetragauge
