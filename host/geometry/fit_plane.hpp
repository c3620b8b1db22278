// SPDX-License-Identifier: GPL-3.0-or-later
// Weighted total-least-squares plane: minimises sum w_i (n . p_i - d)^2 over unit n (orthogonal distance
// regression; the smallest eigenvector of the weighted scatter, see Shakarji, J. Res. NIST 103 (1998) 633).
#pragma once

#include <optional>
#include <span>

#include "host/geometry/face.hpp"

namespace tetragauge {

struct PlaneFit {
  Vec3 normal = Vec3::Zero();  // unit; its sign is that of `towards`
  double d_mm = 0;
  Vec3 centroid_mm = Vec3::Zero();  // weighted, on the plane
  // With weights 1/sigma^2 (sigma across the plane): covariance of offset at the centroid and tilts about u,
  // v.
  PlaneCovariance covariance;
  double weighted_sum_of_squares = 0;
  size_t points = 0;
};

// nullopt for fewer than 3 points, or points on a line. `weights` may be empty (all 1).
// The normal is turned so that normal . towards >= 0.
std::optional<PlaneFit> fit_plane(std::span<const Vec3> points, std::span<const double> weights,
                                  const Vec3& towards);

}  // namespace tetragauge
