// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/surface_problem.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace tetragauge {
namespace {

constexpr size_t kModelSamples = 6000, kScanSamples = 6000, kScanPoints = 30000;
constexpr size_t kOrigins = 12;
constexpr double kLeastCosine = 0.26;  // 75 degrees

// Indices 0 .. size-1 in an order whose first parts are all spread evenly: multiples of the golden section.
std::vector<size_t> spread_indices(size_t size, size_t count) {
  std::vector<size_t> indices;
  std::vector<bool> taken(size, false);
  double u = 0.5;
  // Nearly every step hits a new index as long as few are taken; the limit ends the search for the last ones.
  for (size_t step = 0; indices.size() < std::min(size, count) && step < 4 * count; ++step) {
    u += 0.6180339887498949;
    u -= std::floor(u);
    const auto i = std::min(size - 1, static_cast<size_t>(u * static_cast<double>(size)));
    if (taken[i]) continue;
    taken[i] = true;
    indices.push_back(i);
  }
  return indices;
}

// The farthest from those chosen, again and again, as long as it is far from all of them.
std::vector<Vec3> spread_origins(const std::vector<Vec3>& all, double near_mm) {
  std::vector<Vec3> chosen{all.front()};
  std::vector<double> distance(all.size(), std::numeric_limits<double>::max());
  while (chosen.size() < kOrigins) {
    for (size_t i = 0; i < all.size(); ++i)
      distance[i] = std::min(distance[i], (all[i] - chosen.back()).norm());
    const auto farthest = std::max_element(distance.begin(), distance.end());
    if (*farthest < near_mm) break;
    chosen.push_back(all[static_cast<size_t>(farthest - distance.begin())]);
  }
  return chosen;
}

// Such that nine of ten points have a neighbour that near.
double spacing_mm(const std::vector<SurfaceSample>& samples) {
  std::vector<double> nearest;
  for (size_t i = 0; i < std::min<size_t>(300, samples.size()); ++i) {
    double least = std::numeric_limits<double>::max();
    for (size_t k = 0; k < samples.size(); ++k)
      if (k != i) least = std::min(least, (samples[k].point_mm - samples[i].point_mm).squaredNorm());
    nearest.push_back(std::sqrt(least));
  }
  if (nearest.empty()) return 0;
  const auto at = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() * 9 / 10);
  std::nth_element(nearest.begin(), at, nearest.end());
  return *at;
}

}  // namespace

SurfaceProblem surface_problem(const Solid& model, const RayCaster& caster, const Scan& scan) {
  std::vector<RayPoint> points;
  std::vector<SurfaceSample> scanned;
  for (const size_t i : spread_indices(scan.size(), kScanPoints)) {
    points.push_back({scan.points[i], -scan.ray_direction(i), (scan.points[i] - scan.ray_origins[i]).norm(),
                      static_cast<double>(scan.sigma_mm[i])});
    if (scanned.size() < kScanSamples) scanned.push_back({scan.points[i], Vec3::Zero(), -1});
  }
  const double size_mm = (model.box_max_mm - model.box_min_mm).norm();
  SurfaceProblem problem{model.faces(),
                         caster,
                         ShadowCaster(model),
                         NearestSample(surface_samples(model, kModelSamples), true),
                         NearestSample(std::move(scanned), false),
                         std::move(points),
                         spread_origins(scan.ray_origins, 0.2 * size_mm),
                         size_mm,
                         model.centroid_mm,
                         0,
                         0};
  problem.model_spacing_mm = spacing_mm(problem.model.samples());
  problem.scan_spacing_mm = spacing_mm(problem.scan.samples());
  return problem;
}

std::vector<VisibleSample> visible_samples(const SurfaceProblem& problem, const RigidTransform& T,
                                           size_t count) {
  std::vector<VisibleSample> visible;
  std::vector<Vec3> origins;
  for (const Vec3& origin : problem.origins) origins.push_back(T * origin);
  const double clear_mm = 1e-3 * problem.size_mm;
  const std::vector<SurfaceSample>& samples = problem.model.samples();
  std::vector<std::pair<double, size_t>> squarely;  // cosine, origin
  for (size_t i = 0; i < std::min(count, samples.size()); ++i) {
    squarely.clear();
    for (size_t k = 0; k < origins.size(); ++k) {
      const double cosine = (origins[k] - samples[i].point_mm).normalized().dot(samples[i].normal);
      if (cosine > kLeastCosine) squarely.push_back({cosine, k});
    }
    std::sort(squarely.begin(), squarely.end(), std::greater<>());
    const Vec3 above = samples[i].point_mm + clear_mm * samples[i].normal;
    // The triangles will do: the samples lie on them.
    for (const auto& [cosine, k] : squarely) {
      if (problem.shadows.occluded(above, origins[k])) continue;
      visible.push_back({&samples[i], cosine});
      break;
    }
  }
  return visible;
}

}  // namespace tetragauge
