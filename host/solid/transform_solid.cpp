// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/solid.hpp"

namespace tetragauge {
namespace {

class TransformedSurface : public ParametricSurface {
 public:
  TransformedSurface(std::shared_ptr<const ParametricSurface> surface, const RigidTransform& T)
      : surface_(std::move(surface)), T_(T) {}
  SurfacePoint at(const SurfaceParameters& uv) const override {
    const SurfacePoint own = surface_->at(uv);
    return {T_ * own.point_mm, T_.R * own.du, T_.R * own.dv};
  }

 private:
  std::shared_ptr<const ParametricSurface> surface_;
  RigidTransform T_;
};

}  // namespace

std::shared_ptr<const ParametricSurface> transformed(std::shared_ptr<const ParametricSurface> surface,
                                                     const RigidTransform& T) {
  return std::make_shared<TransformedSurface>(std::move(surface), T);
}

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
  for (auto& surface : result.surfaces) surface = transformed(surface, T);
  result.centroid_mm = T * solid.centroid_mm;
  result.box_min_mm = result.box_max_mm = result.vertices.empty() ? T.t : result.vertices[0];
  for (const Vec3& p : result.vertices) {
    result.box_min_mm = result.box_min_mm.cwiseMin(p);
    result.box_max_mm = result.box_max_mm.cwiseMax(p);
  }
  return result;
}

}  // namespace tetragauge
