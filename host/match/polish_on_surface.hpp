// SPDX-License-Identifier: GPL-3.0-or-later
// The last step of a fit to the surface: each measuring ray against where it should have ended; and how well
// a pose does by that.
#pragma once

#include <vector>

#include "host/match/surface_scatter.hpp"

namespace tetragauge {

// Minus twice the log-likelihood of the pose, up to a constant: points off the surface, and surface that rays
// should have met and no point lies on; each counts kMostSurprise at most.
std::vector<double> surface_costs(const SurfaceProblem& problem, const RigidTransform& T,
                                  const SurfaceScatter& scatter);  // per point, then per model sample
double surface_cost(const SurfaceProblem& problem, const RigidTransform& T, const SurfaceScatter& scatter);

// The mean of that and of the same with the points of each face that lies off its place as a whole, by at
// most `most_out_mm`, judged from where it lies, and the face counted as one stray point. By the first alone
// a boss too small says nothing about the pose, by the second alone a large face in its place no more than a
// small one.
double cost_as_made(const SurfaceProblem& problem, const RigidTransform& T, const SurfaceScatter& scatter,
                    double most_out_mm);

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

// The same, but a face whose points lie off their place together, by at most `most_out_mm`, may have grown or
// shrunk by about that: a ball too large by 0.1 mm holds the part by its centre, a plane out of place hardly
// at all.
PolishedPose polish_with_faces_out(const SurfaceProblem& problem, const RigidTransform& start,
                                   const SurfaceScatter& scatter, size_t points, int iterations,
                                   double most_out_mm);

// A small turn and shift about the pivot, model frame.
RigidTransform nudged(const RigidTransform& T, const Vec6& step, const Vec3& pivot_mm);

}  // namespace tetragauge
