// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/score_rays.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

// Beyond 84 degrees of incidence the range says little about where the surface is.
constexpr double kLeastCosine = 0.1;

}  // namespace

RayScore score_rays(const RayCaster& caster, const Scan& scan, const RigidTransform& T, size_t samples,
                    double tolerance_mm) {
  RayScore score;
  const size_t stride = std::max<size_t>(1, scan.size() / std::max<size_t>(1, samples));
  for (size_t i = 0; i < scan.size(); i += stride) {
    const Vec3 origin = T * scan.ray_origins[i];
    const Vec3 point = T * scan.points[i];
    const double range = (point - origin).norm();
    if (!(range > 0)) continue;
    const Vec3 direction = (point - origin) / range;
    const std::optional<RayHit> hit = caster.first_hit(origin, direction);
    const double across = hit ? std::max(kLeastCosine, std::abs(hit->normal.dot(direction))) : 1.0;
    const double tolerance = std::max(3.0 * static_cast<double>(scan.sigma_mm[i]), tolerance_mm / across);
    const bool through = hit && hit->distance_mm < range - tolerance;
    const bool in_air = !hit || hit->distance_mm > range + tolerance;
    score.sampled.push_back({static_cast<uint32_t>(i), hit ? hit->face : -1,
                             hit ? hit->normal : Vec3(Vec3::Zero()), through || in_air});
  }
  return score;
}

}  // namespace tetragauge
