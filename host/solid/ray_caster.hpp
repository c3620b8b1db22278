// SPDX-License-Identifier: GPL-3.0-or-later
// Rays against a solid: candidates from Embree on the tessellation, the hit solved in double on the analytic
// face.
#pragma once

#include <memory>
#include <optional>

#include "host/solid/solid.hpp"

namespace tetragauge {

struct RayHit {
  double distance_mm = 0;  // along the unit direction from the origin
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // outward, of the analytic surface at the hit
  int face = 0;                // index into Solid::faces()
};

// Thread-safe for concurrent const calls. Keeps what it needs of the solid.
class RayCaster {
 public:
  explicit RayCaster(const Solid& solid);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  // First surface beyond `from_mm` on the ray; `direction` is unit.
  std::optional<RayHit> first_hit(const Vec3& origin, const Vec3& direction, double from_mm = 0) const;
  // Whether anything lies between a and b, `clearance_mm` short of either end.
  bool occluded(const Vec3& a, const Vec3& b, double clearance_mm = 1e-6) const;
  bool inside(const Vec3& p) const;
  // Length of the segment a..b inside the material, mm.
  double length_inside(const Vec3& a, const Vec3& b) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace tetragauge
