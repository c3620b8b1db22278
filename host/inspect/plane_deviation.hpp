// SPDX-License-Identifier: GPL-3.0-or-later
// A measured plane against its nominal one, at a place.
#pragma once

#include "host/inspect/face_inspection.hpp"

namespace tetragauge {

// Of the measured plane along the nominal normal n at p, a point of the nominal plane; + = excess material.
inline double height(const PlaneAsMeasured& plane, const Vec3& n, const Vec3& p) {
  return plane.normal.dot(plane.point_mm - p) / plane.normal.dot(n);
}

// What the plane's own offset and tilts (as in its covariance) add to the height at p.
inline Eigen::RowVector3d height_row(const PlaneAsMeasured& plane, const Vec3& p) {
  const Vec3 r = p - plane.point_mm;
  return {1, r.dot(plane.covariance.v), -r.dot(plane.covariance.u)};
}

inline double own_height_variance(const PlaneAsMeasured& plane, const Vec3& p) {
  const Eigen::RowVector3d row = height_row(plane, p);
  return row * plane.covariance.matrix * row.transpose();
}

// The turn from the nominal normal to the measured one, rad, across the nominal.
inline Vec3 tilt_of(const PlaneAsMeasured& plane, const Vec3& n) {
  return n.cross(plane.normal);
}

// Its covariance, of the plane's own points.
inline Mat3 tilt_covariance(const PlaneAsMeasured& plane) {
  Eigen::Matrix<double, 3, 2> frame;
  frame << plane.covariance.u, plane.covariance.v;
  return frame * plane.covariance.matrix.bottomRightCorner<2, 2>() * frame.transpose();
}

}  // namespace tetragauge
