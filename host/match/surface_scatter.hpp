// SPDX-License-Identifier: GPL-3.0-or-later
// How the points lie about the surface in a pose, beyond what each one's own sigma explains.
#pragma once

#include <map>
#include <vector>

#include "host/match/ray_residuals.hpp"

namespace tetragauge {

// How points scatter about the surface beyond their own sigma, and how many of them err together, as those of
// one wave of a camera's depth do: so many count as one.
struct SurfaceScatter {
  double scatter_mm = 0;
  double together = 1;
};

// `out`: by how much faces lie off their place as a whole (faces_out); the scatter is about them as made.
SurfaceScatter surface_scatter(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals,
                               const std::map<int, double>& out = {});

// Of the point from its face as that was made.
double offset_as_made(const RayResidual& residual, const std::map<int, double>& out);

}  // namespace tetragauge
