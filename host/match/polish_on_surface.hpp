// SPDX-License-Identifier: GPL-3.0-or-later
// The last step of a fit to the surface: each measuring ray against where it should have ended, on the
// model's analytic faces; and how well a pose does by that.
#pragma once

#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/match/surface_problem.hpp"

namespace tetragauge {

struct RayResidual {
  bool near = false;                                    // false: no surface within reach of the point
  double offset_mm = 0;                                 // across the surface, + = outside
  double variance_mm2 = 0;                              // of the offset, by the sensor's own sigma
  Vec3 point_mm = Vec3::Zero(), normal = Vec3::Zero();  // measured point, surface normal, model frame
  int face = -1;                                        // index of the model's; -1: near an edge
};

// Of the first `points` of the scan. A ray that passes the model's edge is measured to the nearest sample.
std::vector<RayResidual> ray_residuals(const SurfaceProblem& problem, const RigidTransform& T, size_t points);

// Across the surface: standard deviation from the median, which stray points do not move.
double scatter_about_surface(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals);

// How points scatter about the surface beyond their own sigma, and how many of them err together, as those of
// one wave of a camera's depth do: so many count as one.
struct SurfaceScatter {
  double scatter_mm = 0;
  double together = 1;
};

SurfaceScatter surface_scatter(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals);

// Minus twice the log-likelihood of the pose, up to a constant: points off the surface, and surface that rays
// should have met and no point lies on; each counts kMostSurprise at most.
std::vector<double> surface_costs(const SurfaceProblem& problem, const RigidTransform& T,
                                  const SurfaceScatter& scatter);  // per point, then per model sample
double surface_cost(const SurfaceProblem& problem, const RigidTransform& T, const SurfaceScatter& scatter);

struct PolishedPose {
  RigidTransform T_model_part;
  Mat6 information = Mat6::Zero();  // of the rays alone, about the problem's pivot, left perturbation
  double rms_mm = 0;                // of the points used
};

// Robust least squares (Tukey's biweight) over `points` rays. Along what rays do not hold it stays within
// about the scan's spacing of the start, which knows the outlines. `held`: a row whose product with the steps
// stays zero.
PolishedPose polish_on_surface(const SurfaceProblem& problem, const RigidTransform& start,
                               const SurfaceScatter& scatter, size_t points, int iterations,
                               const Vec6& held = Vec6::Zero());

// The same, but a face whose points lie off their place together may have grown or shrunk by about that: a
// ball too large by 0.1 mm holds the part by its centre, a plane out of place hardly at all.
PolishedPose polish_with_faces_out(const SurfaceProblem& problem, const RigidTransform& start,
                                   const SurfaceScatter& scatter, size_t points, int iterations);

// A small turn and shift about the pivot, model frame.
RigidTransform nudged(const RigidTransform& T, const Vec6& step, const Vec3& pivot_mm);

}  // namespace tetragauge
