// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/solid.hpp"

namespace tetragauge {

Solid transformed(const Solid& solid, const RigidTransform& T) {
  Solid result = solid;
  for (Face& face : result.list.faces) {
    face.normal = T.R * face.normal;
    face.d_mm += face.normal.dot(T.t);
    face.axis = T.R * face.axis;
    // Planes have no axis: their point on it stays nil.
    if (face.type != SurfaceType::plane && face.type != SurfaceType::other) {
      face.point_on_axis_mm = T * face.point_on_axis_mm;
    }
    face.point_mm = T * face.point_mm;
    if (face.covariance) {
      face.covariance->u = T.R * face.covariance->u;
      face.covariance->v = T.R * face.covariance->v;
    }
  }
  for (Vec3& p : result.vertices) p = T * p;
  result.centroid_mm = T * solid.centroid_mm;
  result.box_min_mm = result.box_max_mm = result.vertices.empty() ? T.t : result.vertices[0];
  for (const Vec3& p : result.vertices) {
    result.box_min_mm = result.box_min_mm.cwiseMin(p);
    result.box_max_mm = result.box_max_mm.cwiseMax(p);
  }
  return result;
}

}  // namespace tetragauge
