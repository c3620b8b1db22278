// SPDX-License-Identifier: GPL-3.0-or-later
// What the measuring rays say about a pose: light went through air up to the point and met material there.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/scan/scan.hpp"
#include "host/solid/ray_caster.hpp"

namespace tetragauge {

struct SampledRay {
  uint32_t ray = 0;            // of the scan
  int face = -1;               // index of the model face its beam met first; -1: none
  Vec3 normal = Vec3::Zero();  // of that face where the beam met it, model frame
  bool is_against = false;     // went through the posed model's material, or ends where that has no surface
};

struct RayScore {
  std::vector<SampledRay> sampled;

  size_t against() const {
    return static_cast<size_t>(
        std::count_if(sampled.begin(), sampled.end(), [](const SampledRay& ray) { return ray.is_against; }));
  }
};

// Every (size / `samples`)-th ray. A ray agrees if the model's surface lies within `tolerance_mm` or three
// sigma of its point, across the surface.
RayScore score_rays(const RayCaster& caster, const Scan& scan, const RigidTransform& T_model_part,
                    size_t samples, double tolerance_mm);

}  // namespace tetragauge
