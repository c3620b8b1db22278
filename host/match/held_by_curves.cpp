// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/held_by_curves.hpp"

#include <algorithm>

#include "host/match/score_rays.hpp"

namespace tetragauge {
namespace {

constexpr size_t kSampled = 10000;
// As few as a face is measured by; each counts by how squarely it stands in the way.
constexpr double kLeastPoints = 30;

}  // namespace

bool curves_hold(const std::vector<FreeDirection>& free, const Solid& model, const RayCaster& caster,
                 const Scan& scan, const RigidTransform& T, double tolerance_mm) {
  const RayScore score = score_rays(caster, scan, T, kSampled, tolerance_mm);
  // Planes that leave a turn free leave shifts free too, and what is curved holds one of these.
  return std::any_of(free.begin(), free.end(), [&](const FreeDirection& direction) {
    if (direction.kind != FreeDirection::Kind::translation) return false;
    double holding = 0;  // of the sampled rays
    for (const SampledRay& ray : score.sampled) {
      if (ray.face < 0 || ray.is_against) continue;
      if (model.faces()[static_cast<size_t>(ray.face)].type == SurfaceType::plane) continue;
      const double cosine = ray.normal.dot(direction.axis);
      holding += cosine * cosine;
    }
    return holding * static_cast<double>(scan.size()) >=
           kLeastPoints * static_cast<double>(score.sampled.size());
  });
}

}  // namespace tetragauge
