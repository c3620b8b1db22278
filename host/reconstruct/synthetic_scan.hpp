// SPDX-License-Identifier: GPL-3.0-or-later
// Scans of analytic parts for the tests of reconstruct and faces: an oracle of its own, independent of
// host/solid and host/simulate.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/scan/pick_points.hpp"
#include "host/scan/scan.hpp"

namespace tetragauge::synthetic {

// Distance along a unit ray to the first hit, or nothing.
using Part = std::function<std::optional<double>(const Vec3& origin, const Vec3& direction)>;

// Polygon in (x, z), counter-clockwise, swept over y from 0 to `length` (mm).
struct Prism {
  std::vector<Eigen::Vector2d> polygon;
  double length = 0;

  bool covers(double x, double z) const {
    bool in = false;
    for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
      const auto &a = polygon[i], &b = polygon[j];
      if ((a.y() > z) != (b.y() > z) && x < (b.x() - a.x()) * (z - a.y()) / (b.y() - a.y()) + a.x()) in = !in;
    }
    return in;
  }
  std::optional<double> operator()(const Vec3& o, const Vec3& d) const {
    std::optional<double> best;
    const auto offer = [&](double t) {
      if (t > 1e-9 && (!best || t < *best)) best = t;
    };
    for (size_t i = 0; i < polygon.size(); ++i) {
      const Eigen::Vector2d a = polygon[i], e = polygon[(i + 1) % polygon.size()] - a;
      const Vec3 normal(e.y(), 0, -e.x());
      const double along = normal.dot(d);
      if (along == 0) continue;
      const double t = normal.dot(Vec3(a.x(), 0, a.y()) - o) / along;
      const Vec3 p = o + t * d;
      const double u = (Eigen::Vector2d(p.x(), p.z()) - a).dot(e) / e.squaredNorm();
      if (u >= 0 && u <= 1 && p.y() >= 0 && p.y() <= length) offer(t);
    }
    for (const double y : {0.0, length}) {
      if (d.y() == 0) continue;
      const double t = (y - o.y()) / d.y();
      const Vec3 p = o + t * d;
      if (covers(p.x(), p.z())) offer(t);
    }
    return best;
  }
};

inline Prism box(double x, double y, double z) {
  return {{{0, 0}, {x, 0}, {x, z}, {0, z}}, y};
}

// The thesis's staircase in mm: 14 planes, 15 faces (x = 0 has two), 80 x 60 x 60.
inline Prism staircase() {
  Prism p{{}, 60};
  for (const auto& [x, z] : {std::pair{0, 0},
                             {8, 0},
                             {8, 2},
                             {6, 2},
                             {6, 4},
                             {4, 4},
                             {4, 5},
                             {2, 5},
                             {2, 6},
                             {0, 6},
                             {0, 4},
                             {3, 1},
                             {0, 1}})
    p.polygon.emplace_back(10.0 * x, 10.0 * z);
  return p;
}

inline std::optional<double> hit_sphere(const Vec3& o, const Vec3& d, const Vec3& centre, double radius) {
  const Vec3 r = o - centre;
  const double b = r.dot(d), c = r.squaredNorm() - radius * radius;
  if (b * b < c) return std::nullopt;
  return -b - std::sqrt(b * b - c);
}

// The 6 axis and 8 corner directions, unit, from the part outwards, slightly turned so that no raster is
// aligned with a face.
inline std::vector<Vec3> fourteen_views() {
  const Mat3 turn = rotation_from_degrees(3, 5, 7);
  std::vector<Vec3> views;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Vec3 v(x, y, z);
        const int parts = x * x + y * y + z * z;
        if (parts == 1 || parts == 3) views.push_back(turn * v.normalized());
      }
    }
  }
  return views;
}

struct ScanPlan {
  std::vector<Vec3> views = fourteen_views();
  Vec3 centre = Vec3::Zero();  // what the views look at, mm
  double half_width_mm = 60;   // of the raster
  double pitch_mm = 2;         // at the centre
  double stand_off_mm = 400;
  double sigma_mm = 0.02;  // normal, along the ray
  double uniform_mm = 0;   // if not 0: uniform in +-this instead, and sigma says its deviation
  uint64_t seed = 1;
};

// `T_scan_part` moves part and views together.
inline Scan scan_part(const Part& part, const ScanPlan& plan, const RigidTransform& T_scan_part = {}) {
  std::mt19937_64 random(plan.seed);
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1.0p-53; };
  Scan scan;
  uint32_t view = 0;
  for (const Vec3& direction : plan.views) {
    const Vec3 origin = plan.centre + plan.stand_off_mm * direction;
    const auto [u, v] = tangent_frame(direction);
    const int n = static_cast<int>(plan.half_width_mm / plan.pitch_mm);
    for (int i = -n; i <= n; ++i) {
      for (int j = -n; j <= n; ++j) {
        // Jittered raster: real mirrors do not repeat to a thousandth of the pitch either.
        const Vec3 aim = plan.centre + plan.pitch_mm * ((i + 0.5 * (uniform() - 0.5)) * u +
                                                        (j + 0.5 * (uniform() - 0.5)) * v);
        const Vec3 ray = (aim - origin).normalized();
        const double first = uniform(), second = uniform();
        const auto hit = part(origin, ray);
        if (!hit) continue;
        double noise =
            plan.sigma_mm * std::sqrt(-2 * std::log(first)) * std::cos(2 * std::numbers::pi * second);
        double sigma = plan.sigma_mm;
        if (plan.uniform_mm > 0) {
          noise = plan.uniform_mm * (2 * first - 1);
          sigma = plan.uniform_mm / std::sqrt(3.0);
        }
        scan.points.push_back(T_scan_part * (origin + (*hit + noise) * ray));
        scan.ray_origins.push_back(T_scan_part * origin);
        scan.sigma_mm.push_back(static_cast<float>(sigma));
        scan.intensity.push_back(1);
        scan.view.push_back(view);
        scan.flags.push_back(0);
      }
    }
    ++view;
  }
  return scan;
}

// The same points in another order.
inline Scan shuffled(const Scan& scan, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<uint32_t> order(scan.size());
  std::iota(order.begin(), order.end(), 0u);
  for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  return pick_points(scan, order);
}

}  // namespace tetragauge::synthetic
