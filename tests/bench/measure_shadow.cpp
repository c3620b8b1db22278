// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/measure_shadow.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

namespace tetragauge::bench {
namespace {

using Micrometres = std::array<int64_t, 3>;

std::vector<Vec3> distinct_vertices(const Solid& solid) {
  std::map<Micrometres, Vec3> distinct;
  for (const Vec3& p : solid.vertices)
    distinct[{std::llround(p.x() * 1e3), std::llround(p.y() * 1e3), std::llround(p.z() * 1e3)}] = p;
  std::vector<Vec3> result;
  for (const auto& [key, p] : distinct) result.push_back(p);
  return result;
}

struct HalfSpace {
  Vec3 normal;
  double d_mm;
};

// Outward planes through all triples of vertices that have no vertex beyond them: enough for parts of some
// hundred vertices.
std::vector<HalfSpace> convex_hull(const Solid& solid) {
  const std::vector<Vec3> p = distinct_vertices(solid);
  std::vector<HalfSpace> hull;
  for (size_t i = 0; i < p.size(); ++i) {
    for (size_t j = i + 1; j < p.size(); ++j) {
      for (size_t k = j + 1; k < p.size(); ++k) {
        Vec3 normal = (p[j] - p[i]).cross(p[k] - p[i]);
        if (!(normal.norm() > 1e-9)) continue;
        normal.normalize();
        double low = 0, high = 0;
        for (const Vec3& q : p) {
          low = std::min(low, normal.dot(q - p[i]));
          high = std::max(high, normal.dot(q - p[i]));
        }
        if (low < -1e-6 && high > 1e-6) continue;
        if (high > 1e-6) normal = -normal;
        const HalfSpace plane{normal, normal.dot(p[i])};
        const auto same = [&](const HalfSpace& h) {
          return (h.normal - normal).norm() < 1e-6 && std::abs(h.d_mm - plane.d_mm) < 1e-6;
        };
        if (std::none_of(hull.begin(), hull.end(), same)) hull.push_back(plane);
      }
    }
  }
  return hull;
}

// Where the light came from, model frame.
std::vector<Vec3> sensors_of(const Scan& scan, const RigidTransform& T) {
  std::map<uint32_t, Vec3> sensors;
  for (size_t i = 0; i < scan.size(); ++i) sensors.try_emplace(scan.view[i], scan.ray_origins[i]);
  std::vector<Vec3> result;
  for (const auto& [view, sensor] : sensors) result.push_back(T.inverse() * sensor);
  return result;
}

double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

}  // namespace

double dark_air_mm3(const Solid& solid, const RayCaster& caster, const Scan& scan, const RigidTransform& T,
                    double max_incidence_rad) {
  constexpr size_t kSamples = 100000;  // a share of 1 % of the box to 3 % of itself
  const std::vector<Vec3> sensors = sensors_of(scan, T);
  const std::vector<HalfSpace> hull = convex_hull(solid);
  const double least_cosine = std::cos(max_incidence_rad);
  const Vec3 size = solid.box_max_mm - solid.box_min_mm;
  std::mt19937_64 random(1);
  size_t dark = 0;
  for (size_t k = 0; k < kSamples; ++k) {
    const double x = uniform(random), y = uniform(random), z = uniform(random);
    const Vec3 p = solid.box_min_mm + size.cwiseProduct(Vec3(x, y, z));
    if (std::any_of(hull.begin(), hull.end(), [&](const HalfSpace& h) { return h.normal.dot(p) > h.d_mm; }) ||
        caster.inside(p))
      continue;
    const bool lit = std::any_of(sensors.begin(), sensors.end(), [&](const Vec3& sensor) {
      const Vec3 direction = (p - sensor).normalized();
      const auto hit = caster.first_hit(sensor, direction);
      return hit && hit->distance_mm > (p - sensor).norm() && -hit->normal.dot(direction) >= least_cosine;
    });
    if (!lit) ++dark;
  }
  return size.prod() * static_cast<double>(dark) / static_cast<double>(kSamples);
}

std::vector<double> dark_share(const Solid& solid, const RayCaster& caster, const Scan& scan,
                               const RigidTransform& T, double max_incidence_rad) {
  constexpr double kSamplesPerMm2 = 4;
  const std::vector<Vec3> sensors = sensors_of(scan, T);
  const double least_cosine = std::cos(max_incidence_rad);
  std::vector<size_t> all(solid.faces().size(), 0), dark(solid.faces().size(), 0);
  std::mt19937_64 random(2);
  for (size_t t = 0; t < solid.triangles.size(); ++t) {
    const Vec3& a = solid.vertices[solid.triangles[t][0]];
    const Vec3 ab = solid.vertices[solid.triangles[t][1]] - a, ac = solid.vertices[solid.triangles[t][2]] - a;
    const uint32_t f = solid.triangle_face[t];
    const Vec3& normal = solid.faces()[f].normal;
    const auto samples = static_cast<size_t>(std::ceil(kSamplesPerMm2 * 0.5 * ab.cross(ac).norm()));
    for (size_t k = 0; k < samples; ++k) {
      double x = uniform(random), y = uniform(random);
      if (x + y > 1) {
        x = 1 - x;
        y = 1 - y;
      }
      const Vec3 p = a + x * ab + y * ac;
      const bool lit = std::any_of(sensors.begin(), sensors.end(), [&](const Vec3& sensor) {
        return normal.dot((sensor - p).normalized()) >= least_cosine && !caster.occluded(sensor, p, 1e-4);
      });
      ++all[f];
      if (!lit) ++dark[f];
    }
  }
  std::vector<double> share(all.size());
  for (size_t f = 0; f < all.size(); ++f)
    share[f] = static_cast<double>(dark[f]) / std::max(1.0, static_cast<double>(all[f]));
  return share;
}

}  // namespace tetragauge::bench
