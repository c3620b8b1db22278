// SPDX-License-Identifier: GPL-3.0-or-later
// What the tests of rays know of bodies: where a line lies in them, from their definition; and random rays.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "host/solid/ray_caster.hpp"

namespace tetragauge::test {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A convex body as the part of a line that lies in it; empty if first > second.
using Span = std::pair<double, double>;
using ConvexBody = std::function<Span(const Vec3& origin, const Vec3& direction)>;

inline Span both(const Span& a, const Span& b) {
  return {std::max(a.first, b.first), std::min(a.second, b.second)};
}

inline Span between(double p, double d, double low, double high) {
  if (d == 0) return p >= low && p <= high ? Span{-kInfinity, kInfinity} : Span{1, 0};
  return {std::min((low - p) / d, (high - p) / d), std::max((low - p) / d, (high - p) / d)};
}

// Where a convex quadratic form a t^2 + 2 b t + c is not above 0; in long double, as an oracle may be.
inline Span below_zero(long double a, long double b, long double c) {
  const long double discriminant = b * b - a * c;
  if (discriminant < 0) return {1, 0};
  const long double root = std::sqrt(discriminant);
  return {static_cast<double>((-b - root) / a), static_cast<double>((-b + root) / a)};
}

inline Span in_box(const Vec3& o, const Vec3& d, const Vec3& low, const Vec3& high) {
  Span span{-kInfinity, kInfinity};
  for (int i = 0; i < 3; ++i) span = both(span, between(o[i], d[i], low[i], high[i]));
  return span;
}

inline Span in_cylinder(const Vec3& o, const Vec3& d, long double radius, double height) {
  using L = long double;
  return both(between(o.z(), d.z(), 0, height),
              below_zero(L(d.x()) * d.x() + L(d.y()) * d.y(), L(o.x()) * d.x() + L(o.y()) * d.y(),
                         L(o.x()) * o.x() + L(o.y()) * o.y() - radius * radius));
}

inline Span in_sphere(const Vec3& o, const Vec3& d, long double radius) {
  using L = long double;
  L b = 0, c = -radius * radius;
  for (int i = 0; i < 3; ++i) {
    b += L(o[i]) * d[i];
    c += L(o[i]) * o[i];
  }
  L a = 0;
  for (int i = 0; i < 3; ++i) a += L(d[i]) * d[i];
  return below_zero(a, b, c);
}

struct Ray {
  Vec3 origin, direction;
};

// From a sphere about the part to a point within `spread` of its middle.
inline Ray random_ray(std::mt19937_64& random, const Vec3& middle, double distance, double spread) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Vec3 way = Vec3(normal(random), normal(random), normal(random)).normalized();
  const Vec3 origin = middle + distance * way;
  const Vec3 target = middle + spread * Vec3(uniform(random), uniform(random), uniform(random));
  return {origin, (target - origin).normalized()};
}

// Random rays against the oracle. Where a ray passes within 0.03 mm of an edge (as `near_edge` says of a
// point), triangles stand for the edge and the answer may differ; nowhere else.
inline void expect_agreement(const Solid& solid, const ConvexBody& body,
                             const std::function<bool(const Vec3&)>& near_edge, int rays) {
  const RayCaster caster(solid);
  const Vec3 middle = 0.5 * (solid.box_min_mm + solid.box_max_mm);
  const double size = (solid.box_max_mm - solid.box_min_mm).norm();
  std::mt19937_64 random(7);
  int hits = 0, edges = 0;
  for (int i = 0; i < rays; ++i) {
    const Ray ray = random_ray(random, middle, 4 * size, 0.5 * size);
    const Span span = body(ray.origin, ray.direction);
    const bool is_hit = span.first < span.second;
    const auto hit = caster.first_hit(ray.origin, ray.direction);
    const double length = caster.length_inside(ray.origin, ray.origin + 8 * size * ray.direction);
    hits += is_hit;
    const auto at = [&](double t) { return Vec3(ray.origin + t * ray.direction); };
    const bool is_edge = (is_hit && (near_edge(at(span.first)) || near_edge(at(span.second)))) ||
                         (hit && near_edge(hit->point_mm));
    if (is_edge) {
      ++edges;
      continue;
    }
    ASSERT_EQ(hit.has_value(), is_hit) << "ray " << i;
    ASSERT_NEAR(length, is_hit ? span.second - span.first : 0, 1e-6) << "ray " << i;
    if (!is_hit) continue;
    ASSERT_NEAR(hit->distance_mm, span.first, 1e-6) << "ray " << i;
    ASSERT_LT(hit->normal.dot(ray.direction), 0) << "ray " << i;
    ASSERT_NEAR(distance_to_surface(solid.faces()[static_cast<size_t>(hit->face)], hit->point_mm), 0, 1e-9);
  }
  EXPECT_GT(hits, rays / 10);
  EXPECT_LT(edges, rays / 50);
}

}  // namespace tetragauge::test
