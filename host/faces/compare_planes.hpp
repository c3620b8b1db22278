// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "host/geometry/fit_plane.hpp"

namespace tetragauge {

// Covariance of a fitted plane (offset, tilts about u and v) carried from its centroid to another point.
PlaneCovariance covariance_at(const PlaneFit& fit, const Vec3& point);

// How much larger than sigma says the residuals are, 1 to 3: form of the face, or a modest sigma. Widens
// gates and covariance, so that a slightly bowed face stays whole and its uncertainty honest.
double noise_scale(const PlaneFit& fit);

// Mahalanobis distance squared (3 degrees of freedom) between two fitted planes that look the same way.
double plane_chi2(const PlaneFit& a, const PlaneFit& b);

// With 3 degrees of freedom a chi-square exceeds this once in 65,000 pairs of truly equal planes.
constexpr double kSamePlaneChi2 = 25;

}  // namespace tetragauge
