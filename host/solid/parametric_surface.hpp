// SPDX-License-Identifier: GPL-3.0-or-later
// A free-form surface as a point for each pair of parameters, without the kernel it came from.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "host/geometry/rigid_transform.hpp"
#include "host/geometry/vec.hpp"

namespace tetragauge {

using SurfaceParameters = std::array<double, 2>;  // u, v

struct SurfacePoint {
  Vec3 point_mm = Vec3::Zero();
  Vec3 du = Vec3::Zero(), dv = Vec3::Zero();  // derivatives, mm per unit of the parameter
};

class ParametricSurface {
 public:
  virtual ~ParametricSurface() = default;
  // Safe for concurrent calls. Beyond the surface's range its last piece goes on.
  virtual SurfacePoint at(const SurfaceParameters& uv) const = 0;
};

// The same surface turned and shifted.
std::shared_ptr<const ParametricSurface> transformed(std::shared_ptr<const ParametricSurface> surface,
                                                     const RigidTransform& T);

// One triangle of the tessellation that stands for a piece of such a surface.
struct TriangleOnSurface {
  uint32_t triangle = 0;                       // index into Solid::triangles
  uint32_t surface = 0;                        // index into Solid::surfaces
  std::array<SurfaceParameters, 3> corners{};  // in the triangle's order
};

}  // namespace tetragauge
