// SPDX-License-Identifier: GPL-3.0-or-later
// From a rough pose to the one in which a scan's points lie on the model's surface.
#pragma once

#include "host/geometry/rigid_transform.hpp"
#include "host/match/surface_problem.hpp"

namespace tetragauge {

struct PullOptions {
  size_t points = 150;  // of the scan
  size_t samples = 0;   // of the model: those seen are pulled to the scan as well
  int iterations = 15;
  double first_mm = 0, last_mm = 0;  // distances beyond which a pull fades, from one to the other
};

// Robust point-to-plane steps from the nearest samples (annealed Geman-McClure).
RigidTransform pull_to_surface(const SurfaceProblem& problem, const RigidTransform& start,
                               const PullOptions& options);

// What speaks against a pose on a scale of distances `scale_mm`: mean over the scan's points and over the
// model's samples that should have been seen of min(distance^2 / scale^2, most), each between 0 and `most`.
struct SurfaceMisfit {
  double points = 0, samples = 0;
  double sum() const { return points + samples; }
};

SurfaceMisfit rough_misfit(const SurfaceProblem& problem, const RigidTransform& T, size_t points,
                           size_t samples, double scale_mm);

// Distances across the surface, for the robust scale.
double median_distance(const SurfaceProblem& problem, const RigidTransform& T, size_t points);

}  // namespace tetragauge
