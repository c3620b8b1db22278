// SPDX-License-Identifier: GPL-3.0-or-later
// The end of the match by the surface: from a pose that is nearly right to the best one, with its
// uncertainty.
#pragma once

#include "host/match/free_on_surface.hpp"
#include "host/match/polish_on_surface.hpp"

namespace tetragauge {

// A pose by all points, with the scatter that it was found with and what it leaves free.
struct SettledPose {
  PolishedPose pose;
  SurfaceScatter scatter;
  SurfaceFreedom freedom;
};

struct NearbyPose {
  RigidTransform T_model_part;
  double cost = 0;  // cost_as_made
};

// By some of the points from up to about `most_out_mm` off the right pose. Faces as a whole may lie off their
// place by as much: a boss that is too small pulls the part to no side, though in its place none of its
// points lie on the model.
NearbyPose approach_surface(const SurfaceProblem& problem, const RigidTransform& start,
                            const SurfaceScatter& rough, double most_out_mm);

// The scatter that the points leave in the best pose near by: with less of it the pose gets better, and with
// a better pose there is less.
SurfaceScatter tightened(const SurfaceProblem& problem, const RigidTransform& start,
                         const SurfaceScatter& rough);

// With all points, and the scatter about the faces as made.
SettledPose settle_on_surface(const SurfaceProblem& problem, const RigidTransform& start,
                              const SurfaceScatter& rough, double most_out_mm);

}  // namespace tetragauge
