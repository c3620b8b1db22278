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

// A shot back at the surface starts at least so far outside: above rounding, below any detail.
constexpr double kBefore_mm = 0.01;

// Of a point to a surface without closed form: along the surface's normal, sought by shooting back at it from
// outside. The ray's own hit lies as far from the foot of the normal as the point's deviation is long and the
// ray flat; each shot shortens that by deviation over radius of curvature, and the error is its square over
// the radius.
double distance_across(const RayCaster& caster, const RayHit& first, const Vec3& point) {
  RayHit foot = first;
  double deviation = foot.normal.dot(point - foot.point_mm);
  for (int shot = 0; shot < 2; ++shot) {
    const double before = 2 * std::abs(deviation) + kBefore_mm;
    const std::optional<RayHit> next = caster.first_hit(point + before * foot.normal, -foot.normal);
    // Over an edge, or behind another face: the tangent plane is the surface that goes on there.
    if (!next || next->face != foot.face || next->distance_mm > 2 * before) break;
    foot = *next;
    deviation = foot.normal.dot(point - foot.point_mm);
  }
  return deviation;
}

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
    out.deviation_mm[i] =
        has_crossings(face) ? distance_to_surface(face, point) : distance_across(caster, *hit, point);
  });
  return out;
}

}  // namespace tetragauge
