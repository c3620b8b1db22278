// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/settle_on_surface.hpp"

#include <cmath>

#include "host/match/faces_out.hpp"
#include "host/match/rank_poses.hpp"

namespace tetragauge {
namespace {

constexpr size_t kNearPoints = 1500, kAllPoints = 30000;

}  // namespace

// The scale at which points lose their say shrinks from where a point that far off is no surprise (graduated
// non-convexity, Yang et al., IEEE RA-L 5 (2020) 1127).
NearbyPose approach_surface(const SurfaceProblem& problem, const RigidTransform& start,
                            const SurfaceScatter& rough, double most_out_mm) {
  const auto finished = [&](const RigidTransform& T) {
    NearbyPose out{polish_with_faces_out(problem, T, rough, kNearPoints, 8, most_out_mm).T_model_part};
    out.cost = cost_as_made(problem, out.T_model_part, rough, most_out_mm);
    return out;
  };
  const NearbyPose at_once = finished(start);
  RigidTransform T = start;
  for (double scale = most_out_mm / std::sqrt(kMostSurprise); scale > rough.scatter_mm; scale *= 0.5) {
    const SurfaceScatter wide{std::hypot(scale, rough.scatter_mm), 1};
    T = polish_with_faces_out(problem, T, wide, kNearPoints, 2, most_out_mm).T_model_part;
  }
  const NearbyPose from_afar = finished(T);
  return from_afar.cost < at_once.cost ? from_afar : at_once;
}

SurfaceScatter tightened(const SurfaceProblem& problem, const RigidTransform& start,
                         const SurfaceScatter& rough) {
  SurfaceScatter scatter = rough;
  RigidTransform T = start;
  for (int pass = 0; pass < 8; ++pass) {
    T = polish_on_surface(problem, T, scatter, kNearPoints, 4).T_model_part;
    const SurfaceScatter next = surface_scatter(problem, ray_residuals(problem, T, kNearPoints));
    if (!(next.scatter_mm < 0.95 * scatter.scatter_mm)) break;
    scatter = next;
  }
  return scatter;
}

SettledPose settle_on_surface(const SurfaceProblem& problem, const RigidTransform& start,
                              const SurfaceScatter& rough, double most_out_mm) {
  SettledPose out;
  const NearbyPose near = approach_surface(problem, start, rough, most_out_mm);
  out.pose = polish_with_faces_out(problem, near.T_model_part, rough, kAllPoints, 12, most_out_mm);
  out.scatter = rough;
  // Faces out of place and the start's own error are no scatter. With less of it more faces stand out.
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<RayResidual> residuals = ray_residuals(problem, out.pose.T_model_part, kAllPoints);
    out.scatter = surface_scatter(problem, residuals, faces_out(residuals, out.scatter, most_out_mm));
    out.pose =
        polish_with_faces_out(problem, out.pose.T_model_part, out.scatter, kAllPoints, 12, most_out_mm);
  }
  out.freedom = free_on_surface(problem, out.pose, out.scatter, kSameCost);
  return out;
}

}  // namespace tetragauge
