// SPDX-License-Identifier: GPL-3.0-or-later
// Each measuring ray of a posed scan against where it should have ended, on the model's analytic faces.
#pragma once

#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/match/surface_problem.hpp"

namespace tetragauge {

struct RayResidual {
  bool near = false;                                   // false: no surface within reach of the point
  double offset_mm = 0;                                // of the point across the face, + = outside
  double variance_mm2 = 0;                             // of the offset, by the sensor's own sigma
  Vec3 foot_mm = Vec3::Zero(), normal = Vec3::Zero();  // on the face, model frame
  int face = -1;                                       // index of the model's
  // Of a ray that met another part of the model first: the point lies so far below that.
  double behind_mm = 0;
};

// Of the first `points` of the scan. A ray that passes the model's edge, or meets the model far from its
// point, is measured to the face of the nearest sample.
std::vector<RayResidual> ray_residuals(const SurfaceProblem& problem, const RigidTransform& T, size_t points);

// Across the surface: standard deviation from the median, which stray points do not move.
double scatter_about_surface(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals);

// Beyond three standard deviations, squared, a point is a stray one.
inline constexpr double kMostSurprise = 9;

// Such that a sample's standard deviation is that times its median absolute value.
inline constexpr double kFromMedian = 1.4826;

// Of an odd number of values the middle one, of an even number the upper of the two; 0 of none.
double median(std::vector<double> values);

}  // namespace tetragauge
