// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/vote_visibility.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>

#include "host/reconstruct/compare_cells.hpp"
#include "host/reconstruct/walk_ray.hpp"

namespace tetragauge {
namespace {

// Distance along the unit direction from `start` to the plane of facet i of a finite cell.
double distance_to_facet(const Tetrahedra& tetrahedra, uint32_t c, int i, const Vec3& start,
                         const Vec3& direction) {
  const Cell& cell = tetrahedra.cells[c];
  // By the vertices' numbers, so that the cells on its two sides see the same rounding.
  const auto& f = kFacet[static_cast<size_t>(i)];
  uint32_t v[3] = {cell.vertex[f[0]], cell.vertex[f[1]], cell.vertex[f[2]]};
  if (v[1] < v[0]) std::swap(v[0], v[1]);
  if (v[2] < v[1]) std::swap(v[1], v[2]);
  if (v[1] < v[0]) std::swap(v[0], v[1]);
  const Vec3& a = tetrahedra.vertices[v[0]];
  const Vec3 normal = (tetrahedra.vertices[v[1]] - a).cross(tetrahedra.vertices[v[2]] - a);
  const double along = normal.dot(direction);
  return along == 0 ? 0 : std::max(0.0, normal.dot(a - start) / along);
}

// Rays of one vertex that are alike.
struct RayBundle {
  Vec3 sensor;
  double weight = 1;  // of each
  Votes rays = 1;
};

class Voter {
 public:
  // With `changed` only cells that are new are voted on; the others have their votes.
  Voter(const Tetrahedra& tetrahedra, const ChangedCells* changed, Visibility& result)
      : tetrahedra_(tetrahedra), changed_(changed), result_(result), walker_(tetrahedra) {}

  // From their sensor to vertex v; `sigma_mm` of the vertex softens the last stretch.
  void vote(uint32_t v, const RayBundle& rays, double sigma_mm) {
    const Vec3& p = tetrahedra_.vertices[v];
    const Vec3 behind = p + (p - rays.sensor).normalized() * (3 * sigma_mm);
    if (changed_ && !changed_->may_be_on(behind, rays.sensor)) return;
    walked += static_cast<size_t>(rays.rays);
    if (!vote_air(v, p, rays, sigma_mm) || !vote_solid(v, p, rays, sigma_mm, behind))
      lost += static_cast<size_t>(rays.rays);
  }

  size_t walked = 0, lost = 0;

 private:
  static Votes votes(const RayBundle& rays, double certainty) {
    return rays.rays * std::lround(static_cast<double>(kOneRay) * (rays.weight * certainty));
  }

  // Sums of integers: the same in whatever order the threads come.
  static void add(Votes& sum, Votes votes) {
    std::atomic_ref<Votes>(sum).fetch_add(votes, std::memory_order_relaxed);
  }
  static void set(uint8_t& flag) {
    std::atomic_ref<uint8_t> shared(flag);
    if (shared.load(std::memory_order_relaxed) == 0) shared.store(1, std::memory_order_relaxed);
  }

  bool is_open(uint32_t c) const { return !changed_ || changed_->number_before()[c] == kNoCell; }
  CellVotes& cell(uint32_t c) { return is_open(c) ? result_.cells[c] : closed_; }

  // That the surface is not here, d before the measured point.
  static double certainty(double d, double sigma_mm) {
    return -std::expm1(-0.5 * d * d / (sigma_mm * sigma_mm));
  }

  // Farther than this from the point every ray's certainty rounds to a whole vote: 16000 exp(-18) is nothing.
  static constexpr double kFarSigmas = 6;

  double centre_distance(uint32_t c, const Vec3& p, const Vec3& direction) const {
    Vec3 sum = Vec3::Zero();
    for (uint32_t v : tetrahedra_.cells[c].vertex) sum += tetrahedra_.vertices[v] - p;
    return std::max(0.0, 0.25 * sum.dot(direction));
  }

  // Walks from the vertex back to the sensor. A facet crossed at distance d is evidence of strength
  // 1 - exp(-d^2 / 2 sigma^2) that the surface is not there.
  bool vote_air(uint32_t v, const Vec3& p, const RayBundle& rays, double sigma_mm) {
    walker_.walk(v, rays.sensor, walk_);
    if (walk_.end == Walk::End::lost) return false;
    const Vec3 direction = (rays.sensor - p).normalized();
    const Votes full = votes(rays, 1);
    uint32_t previous = kNoCell;
    bool is_far = false;
    for (const WalkStep& step : walk_.steps) {
      Votes soft = full;
      if (step.facet_of_previous >= 0) {
        if (!is_far) {
          const double d = distance_to_facet(tetrahedra_, previous, step.facet_of_previous, p, direction);
          soft = votes(rays, certainty(d, sigma_mm));
          is_far = d > kFarSigmas * sigma_mm;
        }
        add(cell(previous).entered_through[static_cast<size_t>(step.facet_of_previous)], soft);
      } else if (previous != kNoCell && !tetrahedra_.cells[previous].is_infinite()) {
        // Through an edge or a vertex: no facet joins the two cells, so the evidence is the far cell's own.
        add(cell(previous).from_outside,
            votes(rays, certainty(centre_distance(previous, p, direction), sigma_mm)));
      }
      add(cell(step.cell).air, soft);
      if (is_open(step.cell)) set(result_.crossed[step.cell]);
      previous = step.cell;
    }
    const uint32_t end = walk_.steps.empty() ? kNoCell : walk_.steps.back().cell;
    if (end != kNoCell) add(cell(end).from_outside, 8 * full);  // the sensor stands in air
    return true;
  }

  // Three sigma beyond the vertex the ray claims solid; on the way there, the deeper the surer.
  bool vote_solid(uint32_t v, const Vec3& p, const RayBundle& rays, double sigma_mm, const Vec3& behind) {
    const Vec3 direction = (p - rays.sensor).normalized();
    walker_.walk(v, behind, walk_);
    if (walk_.end == Walk::End::lost) return false;
    const Votes full = votes(rays, 1);
    uint32_t previous = kNoCell;
    for (const WalkStep& step : walk_.steps) {
      if (step.facet_of_previous >= 0) {
        const double d = distance_to_facet(tetrahedra_, previous, step.facet_of_previous, p, direction);
        const int facet = tetrahedra_.mirror_index(previous, step.facet_of_previous);
        add(cell(step.cell).entered_through[static_cast<size_t>(facet)], votes(rays, certainty(d, sigma_mm)));
      }
      add(cell(step.cell).solid, full);
      previous = step.cell;
    }
    if (walk_.end_cell != kNoCell) {
      add(cell(walk_.end_cell).into_inside, full);
      if (previous != walk_.end_cell) add(cell(walk_.end_cell).solid, full);
    }
    return true;
  }

  const Tetrahedra& tetrahedra_;
  const ChangedCells* changed_;
  Visibility& result_;
  CellVotes closed_;  // votes for cells that have theirs
  RayWalker walker_;
  Walk walk_;
};

// Alike ones together; the order among them does not matter for the sums.
void bundle(std::vector<RayBundle>& rays) {
  const auto value = [](const RayBundle& r) {
    return std::tuple(r.sensor.x(), r.sensor.y(), r.sensor.z(), r.weight);
  };
  std::sort(rays.begin(), rays.end(),
            [&](const RayBundle& a, const RayBundle& b) { return value(a) < value(b); });
  size_t kept = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    if (kept > 0 && value(rays[kept - 1]) == value(rays[i]))
      rays[kept - 1].rays += rays[i].rays;
    else
      rays[kept++] = rays[i];
  }
  rays.resize(kept);
}

void vote_all(const Tetrahedra& tetrahedra, const Scan& scan, const AveragedPoints& averaged,
              const ChangedCells* changed, Visibility& result) {
  const std::vector<double> sigma = floored_sigma_mm(scan);
  std::vector<double> sorted = sigma;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(sorted.size() / 2), sorted.end());
  const double typical = sorted[sorted.size() / 2];

  const VertexRays rays_of = vertex_rays(averaged);
  struct Local {
    Voter voter;
    std::vector<RayBundle> rays;
  };
  tbb::enumerable_thread_specific<Local> locals([&] {
    return Local{Voter(tetrahedra, changed, result), {}};
  });
  tbb::parallel_for(tbb::blocked_range<uint32_t>(0, static_cast<uint32_t>(averaged.vertices.size()), 256),
                    [&](const tbb::blocked_range<uint32_t>& range) {
                      Local& local = locals.local();
                      for (uint32_t v = range.begin(); v < range.end(); ++v) {
                        local.rays.clear();
                        for (const uint32_t i : rays_of.of(v)) {
                          // Weight by information, bounded so that no ray can shout down hundreds of others,
                          // or is not heard.
                          const double weight =
                              std::clamp(typical * typical / (sigma[i] * sigma[i]), 1.0 / 16, 16.0);
                          local.rays.push_back({scan.ray_origins[i], weight, 1});
                        }
                        bundle(local.rays);
                        for (const RayBundle& rays : local.rays)
                          local.voter.vote(v, rays, averaged.sigma_mm[v]);
                      }
                    });
  for (const Local& local : locals) {
    if (!changed) result.rays_walked += local.voter.walked;
    result.rays_lost += local.voter.lost;
  }
}

}  // namespace

Visibility vote_visibility(const Tetrahedra& tetrahedra, const Scan& scan, const AveragedPoints& averaged) {
  Visibility result;
  result.cells.assign(tetrahedra.cells.size(), {});
  result.crossed.assign(tetrahedra.cells.size(), 0);
  vote_all(tetrahedra, scan, averaged, nullptr, result);
  return result;
}

Visibility vote_again(const Tetrahedra& tetrahedra, const Scan& scan, const AveragedPoints& averaged,
                      const Tetrahedra& before, const Visibility& visibility_before) {
  const ChangedCells changed(before, tetrahedra);
  if (changed.hull_has_changed()) return vote_visibility(tetrahedra, scan, averaged);
  Visibility result;
  result.rays_walked = visibility_before.rays_walked;
  result.rays_lost = visibility_before.rays_lost;
  result.cells.assign(tetrahedra.cells.size(), {});
  result.crossed.assign(tetrahedra.cells.size(), 0);
  for (size_t c = 0; c < tetrahedra.cells.size(); ++c) {
    const uint32_t old = changed.number_before()[c];
    if (old == kNoCell) continue;
    result.cells[c] = visibility_before.cells[old];
    result.crossed[c] = visibility_before.crossed[old];
  }
  vote_all(tetrahedra, scan, averaged, &changed, result);
  return result;
}

}  // namespace tetragauge
