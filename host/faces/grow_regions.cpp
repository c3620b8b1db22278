// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/grow_regions.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/geometry/fit_plane.hpp"

namespace tetragauge {
namespace {

constexpr double kGate = 3;        // sigma
constexpr double kFacing = -0.02;  // a plane is seen by rays that run against its normal

class Grower {
 public:
  Grower(const Reconstruction& reconstruction, const SurfaceGraph& graph, size_t min_vertices)
      : reconstruction_(reconstruction), graph_(graph), min_vertices_(min_vertices) {
    regions_.vertex_region.assign(graph.size(), kNoRegion);
    mark_.assign(graph.size(), 0);
  }

  Regions run() {
    // Wide neighbourhoods first: they tell planes from noise best. Narrow faces have only close ones; rims of
    // one spacing have enough vertices only along them, once the faces beside them are taken.
    for (const int hops : {3, 2, 1, 4}) {
      for (uint32_t seed : flattest_first(hops)) {
        if (regions_.vertex_region[seed] == kNoRegion) grow_from(seed, hops);
      }
    }
    return std::move(regions_);
  }

 private:
  struct Seed {
    double reduced_chi2;
    uint32_t vertex;
  };
  struct Scratch {
    std::vector<Vec3> points;
    std::vector<double> weights;
  };

  double sigma(uint32_t v, const Vec3& normal) const {
    return sigma_across(reconstruction_.vertex_sigma_mm[v], reconstruction_.vertex_ray[v], normal);
  }

  // Weights depend on the normal: a plain fit gives it, the weighted one follows.
  std::optional<PlaneFit> fit(const std::vector<uint32_t>& members, std::optional<Vec3> normal,
                              Scratch& scratch) const {
    auto& [points, weights] = scratch;
    points.clear();
    weights.clear();
    Vec3 towards = Vec3::Zero();
    for (uint32_t v : members) {
      points.push_back(reconstruction_.vertices[v]);
      towards -= reconstruction_.vertex_ray[v];
    }
    if (!normal) {
      const auto plain = fit_plane(points, {}, towards);
      if (!plain) return std::nullopt;
      normal = plain->normal;
    }
    for (uint32_t v : members) {
      const double s = sigma(v, *normal);
      weights.push_back(1 / (s * s));
    }
    return fit_plane(points, weights, towards);
  }

  std::vector<uint32_t> unassigned_around(uint32_t seed, int hops) const {
    std::vector<uint32_t> near = vertices_within(graph_, seed, hops, 64);
    std::erase_if(near, [&](uint32_t v) { return regions_.vertex_region[v] != kNoRegion; });
    return near;
  }

  // A chi-square with k degrees of freedom is below this with probability 0.999 (Wilson and Hilferty's cube).
  static double chi2_limit(size_t dof) {
    const double k = static_cast<double>(dof), a = 2 / (9 * k);
    return k * std::pow(1 - a + 3.09 * std::sqrt(a), 3);
  }

  std::vector<uint32_t> flattest_first(int hops) const {
    // Wide neighbourhoods overlap so much that every fourth is enough.
    const uint32_t stride = hops == 3 ? 4 : 1;
    constexpr double kNotFlat = -1;
    std::vector<double> flatness((graph_.size() + stride - 1) / stride, kNotFlat);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, flatness.size(), 256), [&](const auto& range) {
      Scratch scratch;
      for (size_t k = range.begin(); k < range.end(); ++k) {
        const auto v = static_cast<uint32_t>(k * stride);
        if (regions_.vertex_region[v] != kNoRegion || graph_.around(v).empty()) continue;
        const std::vector<uint32_t> members = unassigned_around(v, hops);
        if (members.size() < 6) continue;
        const auto plane = fit(members, std::nullopt, scratch);
        if (!plane || plane->weighted_sum_of_squares > chi2_limit(members.size() - 3)) continue;
        flatness[k] = plane->weighted_sum_of_squares / static_cast<double>(members.size() - 3);
      }
    });
    std::vector<Seed> seeds;
    for (size_t k = 0; k < flatness.size(); ++k) {
      if (flatness[k] != kNotFlat) seeds.push_back({flatness[k], static_cast<uint32_t>(k * stride)});
    }
    std::stable_sort(seeds.begin(), seeds.end(),
                     [](const Seed& a, const Seed& b) { return a.reduced_chi2 < b.reduced_chi2; });
    std::vector<uint32_t> order;
    for (const Seed& s : seeds) order.push_back(s.vertex);
    return order;
  }

  bool belongs(uint32_t v, const PlaneFit& plane) const {
    if (plane.normal.dot(reconstruction_.vertex_ray[v]) > kFacing) return false;
    const Vec3 r = reconstruction_.vertices[v] - plane.centroid_mm;
    const Vec3 row(1.0, r.dot(plane.covariance.v), -r.dot(plane.covariance.u));
    const double variance = std::pow(sigma(v, plane.normal), 2) + row.dot(plane.covariance.matrix * row);
    const double distance = r.dot(plane.normal);
    return distance * distance <= kGate * kGate * variance;
  }

  void grow_from(uint32_t seed, int hops) {
    std::vector<uint32_t> members = unassigned_around(seed, hops);
    if (members.size() < 6) return;
    auto plane = fit(members, std::nullopt, scratch_);
    if (!plane || plane->weighted_sum_of_squares > chi2_limit(members.size() - 3)) return;
    size_t last = 0;
    // Each round floods with a fixed plane up to twice the members, then fits again; ends when the set is
    // stable.
    for (int round = 0; round < 40; ++round) {
      std::vector<uint32_t> flooded = flood(seed, *plane, 2 * members.size());
      if (flooded.size() < 6) return;
      const bool complete = flooded.size() < 2 * members.size();
      members = std::move(flooded);
      plane = fit(members, plane->normal, scratch_);
      if (!plane) return;
      if (complete && members.size() == last) break;
      last = members.size();
    }
    if (members.size() < min_vertices_) return;
    const auto region = static_cast<int32_t>(regions_.planes.size());
    regions_.planes.push_back({plane->normal, plane->d_mm});
    for (uint32_t v : members) regions_.vertex_region[v] = region;
  }

  std::vector<uint32_t> flood(uint32_t seed, const PlaneFit& plane, size_t limit) {
    ++marks_;
    std::vector<uint32_t> members;
    if (!belongs(seed, plane)) return members;
    members.push_back(seed);
    mark_[seed] = marks_;
    for (size_t at = 0; at < members.size() && members.size() < limit; ++at) {
      for (uint32_t n : graph_.around(members[at])) {
        if (mark_[n] == marks_ || regions_.vertex_region[n] != kNoRegion) continue;
        mark_[n] = marks_;
        if (belongs(n, plane)) members.push_back(n);
      }
    }
    return members;
  }

  const Reconstruction& reconstruction_;
  const SurfaceGraph& graph_;
  size_t min_vertices_;
  Regions regions_;
  std::vector<uint32_t> mark_;
  uint32_t marks_ = 0;
  Scratch scratch_;
};

}  // namespace

Regions grow_regions(const Reconstruction& reconstruction, const SurfaceGraph& graph, size_t min_vertices) {
  return Grower(reconstruction, graph, min_vertices).run();
}

}  // namespace tetragauge
