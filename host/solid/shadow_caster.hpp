// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a solid is in the way, by its triangles alone and in float: many times as fast as RayCaster, and
// wrong within a chord's height of a curved edge.
#pragma once

#include <memory>

#include "host/solid/solid.hpp"

namespace tetragauge {

// Thread-safe for concurrent const calls. Keeps what it needs of the solid.
class ShadowCaster {
 public:
  explicit ShadowCaster(const Solid& solid);
  ~ShadowCaster();
  ShadowCaster(ShadowCaster&&) noexcept;
  ShadowCaster& operator=(ShadowCaster&&) noexcept;

  // Anything between a and b; `a` lies within or near the part's box.
  bool occluded(const Vec3& a, const Vec3& b) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace tetragauge
