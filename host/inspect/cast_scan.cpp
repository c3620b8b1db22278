// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/cast_scan.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "host/solid/surface_crossings.hpp"

namespace tetragauge {
namespace {

// A grazing ray's sigma across the surface would vanish; its own aiming error does not.
constexpr double kLeastCosine = 0.1;

}  // namespace

CastScan cast_scan(const Scan& scan, const Solid& model, const RayCaster& caster, const RigidTransform& T) {
  const size_t n = scan.size();
  const std::vector<Vec3> nil(n, Vec3::Zero());
  const std::vector<double> zero(n, 0.0);
  CastScan out{nil, std::vector<int>(n, -1), nil, nil, nil, zero, zero, zero, zero};
  // Each index writes its own slots: the result does not depend on the threads.
  tbb::parallel_for(size_t{0}, n, [&](size_t i) {
    const Vec3 origin = T * scan.ray_origins[i];
    const Vec3 point = T * scan.points[i];
    out.points_mm[i] = point;
    out.origin_mm[i] = origin;
    const double sigma = static_cast<double>(scan.sigma_mm[i]);
    out.sigma_mm[i] = sigma;
    const double range = (point - origin).norm();
    if (!(range > 0)) return;
    const Vec3 direction = (point - origin) / range;
    out.direction[i] = direction;
    const std::optional<RayHit> hit = caster.first_hit(origin, direction);
    if (!hit) return;
    const Face& face = model.faces()[static_cast<size_t>(hit->face)];
    out.face[i] = hit->face;
    out.hit_mm[i] = hit->point_mm;
    out.beyond_mm[i] = range - hit->distance_mm;
    out.cosine[i] = std::abs(hit->normal.dot(direction));
    out.sigma_mm[i] = sigma * std::max(kLeastCosine, out.cosine[i]);
    // A free-form surface has no closed form: to its tangent plane at the hit.
    out.deviation_mm[i] =
        has_crossings(face) ? distance_to_surface(face, point) : hit->normal.dot(point - hit->point_mm);
  });
  return out;
}

}  // namespace tetragauge
