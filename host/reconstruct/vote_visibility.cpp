// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/vote_visibility.hpp"

#include <algorithm>
#include <cmath>

#include "host/reconstruct/walk_ray.hpp"

namespace tetragauge {
namespace {

// Distance along the unit direction from `start` to the plane of facet i of a finite cell.
double distance_to_facet(const Tetrahedra& tetrahedra, uint32_t c, int i, const Vec3& start,
                         const Vec3& direction) {
  const Cell& cell = tetrahedra.cells[c];
  const auto& f = kFacet[static_cast<size_t>(i)];
  const Vec3& a = tetrahedra.vertices[cell.vertex[f[0]]];
  const Vec3 normal =
      (tetrahedra.vertices[cell.vertex[f[1]]] - a).cross(tetrahedra.vertices[cell.vertex[f[2]]] - a);
  const double along = normal.dot(direction);
  return along == 0 ? 0 : std::max(0.0, normal.dot(a - start) / along);
}

class Voter {
 public:
  Voter(const Tetrahedra& tetrahedra, Visibility& result)
      : tetrahedra_(tetrahedra), result_(result), walker_(tetrahedra) {}

  // A ray of the given weight from `sensor` to vertex v; `sigma_mm` of the vertex softens its last stretch.
  void vote(uint32_t v, const Vec3& sensor, double weight, double sigma_mm) {
    ++result_.rays_walked;
    const Vec3& p = tetrahedra_.vertices[v];
    if (!vote_air(v, p, sensor, weight, sigma_mm) || !vote_solid(v, p, sensor, weight, sigma_mm))
      ++result_.rays_lost;
  }

 private:
  static Votes votes(double weight) { return std::lround(static_cast<double>(kOneRay) * weight); }

  // That the surface is not here, d before the measured point.
  static double certainty(double d, double sigma_mm) {
    return -std::expm1(-0.5 * d * d / (sigma_mm * sigma_mm));
  }

  double centre_distance(uint32_t c, const Vec3& p, const Vec3& direction) const {
    Vec3 sum = Vec3::Zero();
    for (uint32_t v : tetrahedra_.cells[c].vertex) sum += tetrahedra_.vertices[v] - p;
    return std::max(0.0, 0.25 * sum.dot(direction));
  }

  // Walks from the vertex back to the sensor. A facet crossed at distance d is evidence of strength
  // 1 - exp(-d^2 / 2 sigma^2) that the surface is not there.
  bool vote_air(uint32_t v, const Vec3& p, const Vec3& sensor, double weight, double sigma_mm) {
    walker_.walk(v, sensor, walk_);
    if (walk_.end == Walk::End::lost) return false;
    const Vec3 direction = (sensor - p).normalized();
    const Votes full = votes(weight);
    uint32_t previous = kNoCell;
    for (const WalkStep& step : walk_.steps) {
      Votes soft = full;
      if (step.facet_of_previous >= 0) {
        const double d = distance_to_facet(tetrahedra_, previous, step.facet_of_previous, p, direction);
        soft = votes(weight * certainty(d, sigma_mm));
        result_.entered_through[previous][static_cast<size_t>(step.facet_of_previous)] += soft;
      } else if (previous != kNoCell && !tetrahedra_.cells[previous].is_infinite()) {
        // Through an edge or a vertex: no facet joins the two cells, so the evidence is the far cell's own.
        result_.from_outside[previous] +=
            votes(weight * certainty(centre_distance(previous, p, direction), sigma_mm));
      }
      result_.air[step.cell] += soft;
      result_.crossed[step.cell] = 1;
      previous = step.cell;
    }
    const uint32_t end = walk_.steps.empty() ? kNoCell : walk_.steps.back().cell;
    if (end != kNoCell) result_.from_outside[end] += 8 * full;  // the sensor stands in air
    return true;
  }

  // Three sigma beyond the vertex the ray claims solid; on the way there, the deeper the surer.
  bool vote_solid(uint32_t v, const Vec3& p, const Vec3& sensor, double weight, double sigma_mm) {
    const Vec3 direction = (p - sensor).normalized();
    const Vec3 behind = p + direction * (3 * sigma_mm);
    walker_.walk(v, behind, walk_);
    if (walk_.end == Walk::End::lost) return false;
    const Votes full = votes(weight);
    uint32_t previous = kNoCell;
    for (const WalkStep& step : walk_.steps) {
      if (step.facet_of_previous >= 0) {
        const double d = distance_to_facet(tetrahedra_, previous, step.facet_of_previous, p, direction);
        const int facet = tetrahedra_.mirror_index(previous, step.facet_of_previous);
        result_.entered_through[step.cell][static_cast<size_t>(facet)] +=
            votes(weight * certainty(d, sigma_mm));
      }
      result_.solid[step.cell] += full;
      previous = step.cell;
    }
    if (walk_.end_cell != kNoCell) {
      result_.into_inside[walk_.end_cell] += full;
      if (previous != walk_.end_cell) result_.solid[walk_.end_cell] += full;
    }
    return true;
  }

  const Tetrahedra& tetrahedra_;
  Visibility& result_;
  RayWalker walker_;
  Walk walk_;
};

}  // namespace

Visibility vote_visibility(const Tetrahedra& tetrahedra, const Scan& scan, const AveragedPoints& averaged) {
  Visibility result;
  const size_t n = tetrahedra.cells.size();
  result.from_outside.assign(n, 0);
  result.air.assign(n, 0);
  result.solid.assign(n, 0);
  result.into_inside.assign(n, 0);
  result.crossed.assign(n, 0);
  result.entered_through.assign(n, {});

  const std::vector<double> sigma = floored_sigma_mm(scan);
  std::vector<double> sorted = sigma;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(sorted.size() / 2), sorted.end());
  const double typical = sorted[sorted.size() / 2];

  Voter voter(tetrahedra, result);
  for (size_t i = 0; i < scan.size(); ++i) {
    const uint32_t v = averaged.point_vertex[i];
    // Weight by information, bounded so that no ray can shout down hundreds of others, or is not heard.
    const double weight = std::clamp(typical * typical / (sigma[i] * sigma[i]), 1.0 / 16, 16.0);
    voter.vote(v, scan.ray_origins[i], weight, averaged.sigma_mm[v]);
  }
  return result;
}

}  // namespace tetragauge
