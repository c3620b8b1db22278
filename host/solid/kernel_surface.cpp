// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/kernel_surface.hpp"

#include <BRep_Tool.hxx>
#include <Geom_Surface.hxx>
#include <gp_Pnt.hxx>
#include <gp_Vec.hxx>

namespace tetragauge {
namespace {

// The surface itself and no adaptor: adaptors keep the last piece they were asked for, and would need a lock.
class KernelSurface : public ParametricSurface {
 public:
  explicit KernelSurface(Handle(Geom_Surface) surface) : surface_(std::move(surface)) {}
  SurfacePoint at(const SurfaceParameters& uv) const override {
    gp_Pnt p;
    gp_Vec du, dv;
    surface_->D1(uv[0], uv[1], p, du, dv);
    return {Vec3(p.X(), p.Y(), p.Z()), Vec3(du.X(), du.Y(), du.Z()), Vec3(dv.X(), dv.Y(), dv.Z())};
  }

 private:
  Handle(Geom_Surface) surface_;
};

}  // namespace

std::shared_ptr<const ParametricSurface> kernel_surface(const TopoDS_Face& face) {
  return std::make_shared<KernelSurface>(BRep_Tool::Surface(face));
}

}  // namespace tetragauge
