// SPDX-License-Identifier: GPL-3.0-or-later
// Directions in which the model can move under the scan without the points noticing: about the axis of a
// round part, along a bar whose ends were not seen.
#pragma once

#include <vector>

#include "host/match/match.hpp"
#include "host/match/polish_on_surface.hpp"

namespace tetragauge {

struct SurfaceFreedom {
  std::vector<FreeDirection> undetermined;
  Mat6 covariance = Mat6::Zero();  // none along the free directions
};

SurfaceFreedom free_on_surface(const SurfaceProblem& problem, const PolishedPose& pose,
                               const SurfaceScatter& scatter, double same_cost);

// Turn and shift between two poses that no free direction explains: radians, and mm at the part's `middle`.
struct PoseDifference {
  double turn_rad = 0, shift_mm = 0;
};

PoseDifference apart_but_for(const RigidTransform& a, const RigidTransform& b, const Vec3& part_middle,
                             const std::vector<FreeDirection>& free);

}  // namespace tetragauge
