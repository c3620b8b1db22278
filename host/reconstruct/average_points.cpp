// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/average_points.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>

#include "host/geometry/fit_plane.hpp"
#include "host/reconstruct/point_spacing.hpp"

namespace tetragauge {
namespace {

using GridKey = std::array<int64_t, 3>;

std::tuple<double, double, double> coordinates(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

// The points by cubes as wide as the reach: those within reach of a point are in its own or a neighbouring
// one.
class Neighbourhoods {
 public:
  Neighbourhoods(const Scan& scan, const std::vector<uint32_t>& order, double reach_mm)
      : scan_(scan), reach_mm_(reach_mm) {
    sort_into_grid(order);
  }

  double reach_mm() const { return reach_mm_; }
  int64_t column(uint32_t i) const { return key(i)[0]; }  // along x

  // Points within reach that were seen from the same side, the seed among them, nearest cells in fixed order.
  void collect_around(uint32_t seed, std::vector<uint32_t>& around) const {
    around.clear();
    const GridKey k = key(seed);
    const Vec3 ray = scan_.points[seed] - scan_.ray_origins[seed];
    for (int64_t x = k[0] - 1; x <= k[0] + 1; ++x) {
      for (int64_t y = k[1] - 1; y <= k[1] + 1; ++y) {
        // Three cells in a row are neighbours in the sorted list.
        auto cell = std::lower_bound(cells_.begin(), cells_.end(), GridKey{x, y, k[2] - 1});
        for (; cell != cells_.end() && (*cell)[0] == x && (*cell)[1] == y && (*cell)[2] <= k[2] + 1; ++cell) {
          const auto c = static_cast<size_t>(cell - cells_.begin());
          for (size_t at = cell_begin_[c]; at < cell_begin_[c + 1]; ++at) {
            const uint32_t i = sorted_[at];
            if ((scan_.points[i] - scan_.points[seed]).squaredNorm() <= reach_mm_ * reach_mm_ &&
                ray.dot(scan_.points[i] - scan_.ray_origins[i]) > 0)
              around.push_back(i);
          }
        }
      }
    }
  }

 private:
  GridKey key(uint32_t i) const {
    const Vec3 g = (scan_.points[i] - origin_) / reach_mm_;
    return {static_cast<int64_t>(std::floor(g.x())), static_cast<int64_t>(std::floor(g.y())),
            static_cast<int64_t>(std::floor(g.z()))};
  }

  void sort_into_grid(const std::vector<uint32_t>& order) {
    origin_ = scan_.points[order.front()];
    for (uint32_t i : order) origin_ = origin_.cwiseMin(scan_.points[i]);
    std::vector<std::pair<GridKey, uint32_t>> keyed;  // with the place in the order
    keyed.reserve(order.size());
    for (uint32_t at = 0; at < order.size(); ++at) keyed.emplace_back(key(order[at]), at);
    tbb::parallel_sort(keyed);
    for (const auto& [k, at] : keyed) {
      if (cells_.empty() || cells_.back() != k) {
        cells_.push_back(k);
        cell_begin_.push_back(sorted_.size());
      }
      sorted_.push_back(order[at]);
    }
    cell_begin_.push_back(sorted_.size());
  }

  const Scan& scan_;
  double reach_mm_;
  Vec3 origin_;
  std::vector<uint32_t> sorted_;    // by grid cell, canonical within
  std::vector<GridKey> cells_;      // occupied, ascending
  std::vector<size_t> cell_begin_;  // into sorted_, and its size at the end
};

// What one slab of points along x becomes.
struct SlabVertices {
  std::vector<Vec3> vertices;
  std::vector<float> sigma_mm;
  std::vector<Vec3> ray;
  std::vector<std::pair<uint32_t, uint32_t>> point_vertex;  // point, vertex of this slab
};

class Averager {
 public:
  Averager(const Scan& scan, const std::vector<double>& sigma_mm, double spacing_mm,
           const Neighbourhoods& neighbourhoods, std::vector<uint8_t>& taken)
      : scan_(scan),
        sigma_mm_(sigma_mm),
        spacing_mm_(spacing_mm),
        neighbourhoods_(neighbourhoods),
        taken_(taken) {}

  // Each point in turn, if it is not in a vertex yet, gathers the free points around it that lie on its local
  // plane. Neighbourhoods that are not plane are halved, twice; then the point stays alone, or with its
  // crowd.
  SlabVertices run(std::span<const uint32_t> seeds) {
    std::vector<uint32_t> around, members;
    for (uint32_t seed : seeds) {
      if (taken_[seed]) continue;
      neighbourhoods_.collect_around(seed, around);
      members.assign(1, seed);
      bool is_plane = around.size() < 2;
      for (double scale = 1; scale >= 0.25 && !is_plane; scale /= 2)
        is_plane = gather(seed, around, scale, members);
      if (!is_plane) gather_crowd(seed, around, members);
      for (uint32_t i : members) taken_[i] = 1;
      add_vertex(members);
    }
    return std::move(result_);
  }

 private:
  // If the points within `scale` times the reach lie on a plane: the free ones that are near the seed along
  // it become members.
  bool gather(uint32_t seed, const std::vector<uint32_t>& around, double scale,
              std::vector<uint32_t>& members) {
    const double reach2 = std::pow(scale * neighbourhoods_.reach_mm(), 2);
    near_.clear();
    for (uint32_t i : around) {
      if ((scan_.points[i] - scan_.points[seed]).squaredNorm() <= reach2) near_.push_back(i);
    }
    if (near_.size() < 2) return true;
    const auto plane = local_plane();
    if (!plane || std::abs(plane->normal.dot(scan_.points[seed]) - plane->d_mm) > gate(seed, plane->normal))
      return false;
    // Half a disc (the other half went to earlier seeds) of 0.8 of the spacing has the area of its square; a
    // little more, so that regular rasters just wider than that are averaged too.
    const double radius2 = std::pow(0.9 * scale * spacing_mm_, 2);
    for (uint32_t i : near_) {
      if (i == seed || taken_[i]) continue;
      const Vec3 r = scan_.points[i] - scan_.points[seed];
      const double height = plane->normal.dot(r);
      if (r.squaredNorm() - height * height > radius2) continue;
      if (std::abs(plane->normal.dot(scan_.points[i]) - plane->d_mm) <= gate(i, plane->normal))
        members.push_back(i);
    }
    return true;
  }

  // A machine that stands still gives one place again and again: such points have no plane of their own, and
  // if each stayed alone and asked all others in turn the time would go with their square. This close to each
  // other, compared with the noise, no shape is lost by averaging them. Scans of a moving beam have no
  // crowds.
  void gather_crowd(uint32_t seed, const std::vector<uint32_t>& around, std::vector<uint32_t>& members) {
    constexpr size_t kCrowd = 16;
    constexpr double kReachSigmas = 0.01;
    const double reach2 = std::pow(kReachSigmas * sigma_mm_[seed], 2);
    near_.clear();
    for (uint32_t i : around) {
      if (i != seed && !taken_[i] && (scan_.points[i] - scan_.points[seed]).squaredNorm() <= reach2)
        near_.push_back(i);
    }
    if (near_.size() >= kCrowd) members.insert(members.end(), near_.begin(), near_.end());
  }

  double gate(uint32_t i, const Vec3& normal) const {
    return 3.5 * sigma_mm_[i] * std::max(0.05, std::abs(normal.dot(scan_.ray_direction(i))));
  }

  // Of near_; nothing if they do not lie on one plane. A tenth of them may be outliers.
  std::optional<PlaneFit> local_plane() {
    constexpr size_t kEnoughToJudge = 6;  // 3 parameters, and as many degrees of freedom to test them
    if (near_.size() < kEnoughToJudge) return std::nullopt;
    std::vector<uint32_t> used = near_;
    for (int pass = 0; pass < 2; ++pass) {
      points_.clear();
      weights_.clear();
      for (uint32_t i : used) {
        points_.push_back(scan_.points[i]);
        weights_.push_back(1 / (sigma_mm_[i] * sigma_mm_[i]));
      }
      const auto plane = fit_plane(points_, weights_, Vec3::UnitZ());
      if (!plane) return std::nullopt;
      std::vector<uint32_t> good;
      double chi2 = 0;
      for (uint32_t i : used) {
        const double distance = plane->normal.dot(scan_.points[i]) - plane->d_mm;
        const double limit = gate(i, plane->normal);
        if (std::abs(distance) > limit) continue;
        good.push_back(i);
        chi2 += std::pow(3.5 * distance / limit, 2);
      }
      if (10 * good.size() < 9 * near_.size()) return std::nullopt;
      // Twice the expected value: past that it is a crease or a curve, not noise.
      if (good.size() == used.size())
        return chi2 <= 2 * static_cast<double>(good.size() - 3) ? plane : std::nullopt;
      used = std::move(good);
      if (used.size() < kEnoughToJudge) return std::nullopt;
    }
    return std::nullopt;
  }

  void add_vertex(std::span<const uint32_t> members) {
    double total = 0;
    Vec3 mean = Vec3::Zero(), ray = Vec3::Zero();
    const Vec3 base = scan_.points[members.front()];
    for (uint32_t i : members) {
      const double weight = 1 / (sigma_mm_[i] * sigma_mm_[i]);
      total += weight;
      mean += weight * (scan_.points[i] - base);
      ray += weight * scan_.ray_direction(i);
    }
    const auto index = static_cast<uint32_t>(result_.vertices.size());
    result_.vertices.push_back(base + mean / total);
    result_.sigma_mm.push_back(static_cast<float>(1 / std::sqrt(total)));
    result_.ray.push_back(ray.normalized());  // all within 90 degrees of the first: never zero
    for (uint32_t i : members) result_.point_vertex.emplace_back(i, index);
  }

  const Scan& scan_;
  const std::vector<double>& sigma_mm_;
  double spacing_mm_;
  const Neighbourhoods& neighbourhoods_;
  std::vector<uint8_t>& taken_;
  SlabVertices result_;
  std::vector<uint32_t> near_;
  std::vector<Vec3> points_;
  std::vector<double> weights_;
};

// Where slabs begin in `order`, and its end: each at least three cubes wide, so that two with one between
// them never want the same point, and of enough points to be worth a task.
std::vector<size_t> cut_into_slabs(const std::vector<uint32_t>& order, const Neighbourhoods& neighbourhoods) {
  constexpr size_t kPoints = 1 << 14;
  constexpr int64_t kCubes = 3;
  std::vector<size_t> begin{0};
  int64_t first = neighbourhoods.column(order.front()), last = first;
  for (size_t at = 1; at < order.size(); ++at) {
    const int64_t column = neighbourhoods.column(order[at]);
    if (column != last && column - first >= kCubes && at - begin.back() >= kPoints) {
      begin.push_back(at);
      first = column;
    }
    last = column;
  }
  begin.push_back(order.size());
  return begin;
}

// In slabs along x: every other one first, then those between, which take what these have left.
void average(const Scan& scan, const std::vector<double>& sigma_mm, double spacing_mm,
             const std::vector<uint32_t>& order, AveragedPoints& result) {
  const Neighbourhoods neighbourhoods(scan, order, 1.5 * spacing_mm);
  const std::vector<size_t> begin = cut_into_slabs(order, neighbourhoods);
  const size_t slabs = begin.size() - 1;
  std::vector<SlabVertices> made(slabs);
  std::vector<uint8_t> taken(scan.size(), 0);
  for (size_t first = 0; first < 2; ++first) {
    tbb::parallel_for(first, slabs, size_t{2}, [&](size_t k) {
      made[k] = Averager(scan, sigma_mm, spacing_mm, neighbourhoods, taken)
                    .run(std::span(order).subspan(begin[k], begin[k + 1] - begin[k]));
    });
  }
  for (const SlabVertices& slab : made) {
    const auto before = static_cast<uint32_t>(result.vertices.size());
    result.vertices.insert(result.vertices.end(), slab.vertices.begin(), slab.vertices.end());
    result.sigma_mm.insert(result.sigma_mm.end(), slab.sigma_mm.begin(), slab.sigma_mm.end());
    result.ray.insert(result.ray.end(), slab.ray.begin(), slab.ray.end());
    for (const auto& [point, vertex] : slab.point_vertex) result.point_vertex[point] = before + vertex;
  }
}

// Along Morton's curve, so that what is near in space is near in memory: the bits of x, y and z in turn.
std::vector<uint32_t> order_along_curve(const std::vector<Vec3>& vertices) {
  constexpr int kBits = 21;  // of each axis: three fit into 64
  Vec3 low = vertices.front(), high = low;
  for (const Vec3& p : vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double steps_per_mm = ((1 << kBits) - 1) / std::max((high - low).maxCoeff(), 1e-300);
  std::vector<std::pair<uint64_t, uint32_t>> coded(vertices.size());
  for (uint32_t v = 0; v < vertices.size(); ++v) {
    uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const auto step = static_cast<uint64_t>((vertices[v][k] - low[k]) * steps_per_mm);
      for (int bit = 0; bit < kBits; ++bit) code |= (step >> bit & 1) << (3 * bit + k);
    }
    coded[v] = {code, v};
  }
  std::sort(coded.begin(), coded.end());
  std::vector<uint32_t> order;
  order.reserve(coded.size());
  for (const auto& [code, v] : coded) order.push_back(v);
  return order;
}

// Distinct, in canonical order; vertices at exactly the same place become one (their sigmas combine).
void sort_and_unite(AveragedPoints& averaged) {
  const size_t n = averaged.vertices.size();
  std::vector<uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return coordinates(averaged.vertices[a]) < coordinates(averaged.vertices[b]);
  });
  AveragedPoints sorted;
  std::vector<uint32_t> new_index(n);
  for (uint32_t i : order) {
    if (sorted.vertices.empty() || averaged.vertices[i] != sorted.vertices.back()) {
      sorted.vertices.push_back(averaged.vertices[i]);
      sorted.sigma_mm.push_back(averaged.sigma_mm[i]);
      sorted.ray.push_back(averaged.ray[i]);
    } else {
      const double a = sorted.sigma_mm.back(), b = averaged.sigma_mm[i];
      sorted.sigma_mm.back() = static_cast<float>(a * b / std::hypot(a, b));
    }
    new_index[i] = static_cast<uint32_t>(sorted.vertices.size() - 1);
  }
  const std::vector<uint32_t> along = order_along_curve(sorted.vertices);
  std::vector<uint32_t> place(along.size());
  averaged.vertices.resize(along.size());
  averaged.sigma_mm.resize(along.size());
  averaged.ray.resize(along.size());
  for (uint32_t at = 0; at < along.size(); ++at) {
    averaged.vertices[at] = sorted.vertices[along[at]];
    averaged.sigma_mm[at] = sorted.sigma_mm[along[at]];
    averaged.ray[at] = sorted.ray[along[at]];
    place[along[at]] = at;
  }
  for (uint32_t& v : averaged.point_vertex) v = place[new_index[v]];
}

}  // namespace

VertexRays vertex_rays(const AveragedPoints& averaged) {
  VertexRays result;
  result.first.assign(averaged.vertices.size() + 1, 0);
  for (uint32_t v : averaged.point_vertex) ++result.first[v + 1];
  for (size_t v = 0; v + 1 < result.first.size(); ++v) result.first[v + 1] += result.first[v];
  result.rays.resize(averaged.point_vertex.size());
  std::vector<uint32_t> next(result.first.begin(), result.first.end() - 1);
  for (uint32_t i = 0; i < averaged.point_vertex.size(); ++i)
    result.rays[next[averaged.point_vertex[i]]++] = i;
  return result;
}

std::vector<uint32_t> canonical_order(const Scan& scan) {
  std::vector<uint32_t> order(scan.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto value = [&](uint32_t i) {
    return std::tuple(coordinates(scan.points[i]), coordinates(scan.ray_origins[i]), scan.sigma_mm[i], i);
  };
  tbb::parallel_sort(order, [&](uint32_t a, uint32_t b) { return value(a) < value(b); });
  return order;
}

std::vector<double> floored_sigma_mm(const Scan& scan) {
  if (scan.size() == 0) return {};
  Vec3 low = scan.points.front(), high = low;
  for (const Vec3& p : scan.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double floor_mm = std::max(1e-6 * (high - low).norm(), 1e-9);
  std::vector<double> sigma(scan.size());
  for (size_t i = 0; i < scan.size(); ++i) sigma[i] = std::max<double>(scan.sigma_mm[i], floor_mm);
  return sigma;
}

AveragedPoints average_points(const Scan& scan, double spacing_mm) {
  AveragedPoints result;
  if (scan.size() == 0) return result;
  const std::vector<uint32_t> order = canonical_order(scan);
  const std::vector<double> sigma = floored_sigma_mm(scan);
  std::vector<double> sorted_sigma = sigma;
  std::nth_element(sorted_sigma.begin(), sorted_sigma.begin() + static_cast<long>(sigma.size() / 2),
                   sorted_sigma.end());
  const double typical_sigma = sorted_sigma[sigma.size() / 2];

  std::vector<Vec3> distinct;
  distinct.reserve(order.size());
  for (uint32_t i : order) {
    if (distinct.empty() || distinct.back() != scan.points[i]) distinct.push_back(scan.points[i]);
  }
  result.point_spacing_mm = point_spacing(distinct, typical_sigma);
  const double s = result.point_spacing_mm;
  // Averaging k points of spacing s into one of spacing h = s sqrt(k) leaves sigma / sqrt(k); h is 10 times
  // that at h = sqrt(10 sigma s). Where s > 10 sigma only crowds (closer than 10 sigma) are averaged.
  result.vertex_spacing_mm = spacing_mm > 0 ? spacing_mm : std::max(s, std::sqrt(10 * typical_sigma * s));
  const double spacing =
      spacing_mm > 0 ? spacing_mm : std::sqrt(10 * typical_sigma * std::min(s, 10 * typical_sigma));

  result.point_vertex.resize(scan.size());
  average(scan, sigma, std::max(spacing, 1e-9), order, result);
  sort_and_unite(result);
  return result;
}

}  // namespace tetragauge
