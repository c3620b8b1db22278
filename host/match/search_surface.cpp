// SPDX-License-Identifier: GPL-3.0-or-later
// Every rotation of a grid gets a start where the middle of the points meets the middle of what they could
// have seen of the model, and a short robust fit; the best go on with more points, and with what the model
// has and the scan should have seen.
#include "host/match/search_surface.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "host/match/fit_surface.hpp"
#include "host/match/rotation_grid.hpp"

namespace tetragauge {
namespace {

constexpr size_t kRotations = 4400;
constexpr size_t kRefined = 80;
constexpr double kAlike_rad = 0.14;   // 8 degrees: half of the grid's own spacing
constexpr double kAlike = 0.03;       // of the model's size
constexpr double kRoughScale = 0.03;  // of the model's size: a misfit beyond that is simply wrong

// The middle of the model's samples as the scan's rays would weigh them, were none in another's shade.
Vec3 middle_of_facing(const SurfaceProblem& problem, const Mat3& R, size_t samples, size_t rays) {
  Vec3 sum = Vec3::Zero();
  double total = 0;
  rays = std::min(rays, problem.points.size());
  samples = std::min(samples, problem.model.samples().size());
  for (size_t k = 0; k < rays; ++k) {
    const Vec3 towards = R * problem.points[k].towards;
    for (size_t i = 0; i < samples; ++i) {
      const double cosine = std::max(0.0, problem.model.samples()[i].normal.dot(towards));
      sum += cosine * problem.model.samples()[i].point_mm;
      total += cosine;
    }
  }
  return total > 0 ? Vec3(sum / total) : problem.pivot_mm;
}

// The first of those alike, by misfit.
std::vector<SurfacePose> distinct(std::vector<SurfacePose> poses, const Vec3& part_middle, double size_mm,
                                  size_t most) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const SurfacePose& a, const SurfacePose& b) { return a.misfit < b.misfit; });
  std::vector<SurfacePose> kept;
  for (const SurfacePose& pose : poses) {
    if (kept.size() == most) break;
    const auto alike = [&](const SurfacePose& other) {
      return rotation_angle(pose.T_model_part.R * other.T_model_part.R.transpose()) < kAlike_rad &&
             (pose.T_model_part * part_middle - other.T_model_part * part_middle).norm() < kAlike * size_mm;
    };
    if (std::none_of(kept.begin(), kept.end(), alike)) kept.push_back(pose);
  }
  return kept;
}

}  // namespace

std::vector<SurfacePose> search_surface(const SurfaceProblem& problem) {
  const double size_mm = problem.size_mm, rough_mm = kRoughScale * size_mm;
  Vec3 middle = Vec3::Zero();
  for (const RayPoint& point : problem.points)
    middle += point.point_mm / static_cast<double>(problem.points.size());

  const std::vector<Mat3> rotations = rotation_grid(kRotations);
  std::vector<SurfacePose> poses(rotations.size());
  tbb::parallel_for(size_t{0}, rotations.size(), [&](size_t k) {
    const Mat3& R = rotations[k];
    const RigidTransform start{R, middle_of_facing(problem, R, 200, 16) - R * middle};
    poses[k].T_model_part = pull_to_surface(
        problem, start,
        {.points = 150, .samples = 0, .iterations = 15, .first_mm = 0.15 * size_mm, .last_mm = rough_mm});
    poses[k].misfit = rough_misfit(problem, poses[k].T_model_part, 200, 100, rough_mm).sum();
  });
  poses = distinct(std::move(poses), middle, size_mm, kRefined);
  tbb::parallel_for(size_t{0}, poses.size(), [&](size_t k) {
    RigidTransform& T = poses[k].T_model_part;
    T = pull_to_surface(
        problem, T,
        {.points = 600, .samples = 600, .iterations = 20, .first_mm = rough_mm, .last_mm = 0.3 * rough_mm});
    poses[k].misfit = rough_misfit(problem, T, 1000, 600, rough_mm).sum();
  });
  return distinct(std::move(poses), middle, size_mm, kRefined);
}

}  // namespace tetragauge
