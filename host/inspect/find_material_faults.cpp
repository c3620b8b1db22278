// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/find_material_faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "host/inspect/decide.hpp"
#include "host/inspect/point_grid.hpp"

namespace tetragauge {
namespace {

constexpr size_t kLeastRays = 8;
constexpr double kLeastShare =
    0.6;  // mixed points along a silhouette are a minority of a window, a feature fills it
constexpr double kWindowSpacings = 2;
// Eight rays or more, most of them off, in a circle of two spacings around one of them, clear of the edge by
// one.
constexpr double kFeatureSpacings = 4;

// One ray that meets the face of the model: where, and how it missed.
struct Ray {
  Vec3 hit_mm;
  double depth_mm = 0;  // from the surface it should have met; 0: none
  int missed = 0;       // -1 went through, +1 stopped short, 0 on the face
};

using Cell = std::array<long, 3>;

class RayGrid {
 public:
  RayGrid(const std::vector<Ray>& rays, double side_mm) : rays_(rays), side_mm_(side_mm) {
    for (size_t i = 0; i < rays.size(); ++i) cells_[cell_of(rays[i].hit_mm)].push_back(i);
  }
  template <class Visit>
  void each_within(const Vec3& p, const Visit& visit) const {  // within side_mm
    const Cell at = cell_of(p);
    for (long x = -1; x <= 1; ++x) {
      for (long y = -1; y <= 1; ++y) {
        for (long z = -1; z <= 1; ++z) {
          const auto found = cells_.find({at[0] + x, at[1] + y, at[2] + z});
          if (found == cells_.end()) continue;
          for (const size_t i : found->second)
            if ((rays_[i].hit_mm - p).norm() <= side_mm_) visit(i);
        }
      }
    }
  }

 private:
  Cell cell_of(const Vec3& p) const {
    return {static_cast<long>(std::floor(p.x() / side_mm_)), static_cast<long>(std::floor(p.y() / side_mm_)),
            static_cast<long>(std::floor(p.z() / side_mm_))};
  }
  const std::vector<Ray>& rays_;
  double side_mm_;
  std::map<Cell, std::vector<size_t>> cells_;
};

// Spacing of the rays where they are dense enough to count: from the eighth neighbour, as n rays in a circle
// of radius r are sqrt(pi r^2 / n) apart. The median over at most 101 of them.
double spacing_of(const std::vector<Ray>& rays) {
  const size_t step = 1 + rays.size() / 101;
  std::vector<double> spacing, distance;
  for (size_t i = 0; i < rays.size(); i += step) {
    distance.clear();
    for (const Ray& other : rays) distance.push_back((other.hit_mm - rays[i].hit_mm).squaredNorm());
    const size_t k = std::min<size_t>(8, rays.size() - 1);
    std::nth_element(distance.begin(), distance.begin() + static_cast<std::ptrdiff_t>(k), distance.end());
    spacing.push_back(std::sqrt(std::numbers::pi * distance[k] / static_cast<double>(k)));
  }
  std::nth_element(spacing.begin(), spacing.begin() + static_cast<std::ptrdiff_t>(spacing.size() / 2),
                   spacing.end());
  return spacing[spacing.size() / 2];
}

double material_limit(const FaceTolerance& tolerance) {
  return std::min(tolerance.flatness_mm.value_or(1e300), offset_limit(tolerance));
}

// Across the surface, beyond what its tolerance allows and three sigma.
double beyond_limit(const CastScan& cast, uint32_t i, double limit_mm) {
  return std::abs(cast.deviation_mm[i]) - (limit_mm + 3 * cast.sigma_mm[i]);
}

// Points of the measured faces that were matched to `face`, whose rays should have met something behind
// them or nothing, and which do not lie on that either, as the first strip of a fillet does: the part's face
// goes on where the model's ends, over a hole that was not made for instance.
std::vector<uint32_t> beyond_its_edge(const Solid& model, const JoinedScan& joined, const Face& face,
                                      const Tolerances& tolerances, double limit_mm) {
  std::vector<uint32_t> beyond;
  for (const MeasuredPatch& patch : joined.patches) {
    if (patch.model_id != face.id) continue;
    for (const uint32_t i : patch.points) {
      const int met = joined.cast.face[i];
      if (met >= 0) {
        const Face& other = model.faces()[static_cast<size_t>(met)];
        if (other.surface == face.surface || joined.cast.beyond_mm[i] >= 0) continue;
        const FaceTolerance its = tolerances.of(other);
        if (beyond_limit(joined.cast, i, has_tolerance(its) ? material_limit(its) : limit_mm) <= 0) continue;
      }
      beyond.push_back(i);
    }
  }
  return beyond;
}

// The rays of one kind that fill a window, in groups that hang together.
void add_faults(const std::vector<Ray>& rays, const RayGrid& grid, int kind, int face_id,
                Inspection& inspection) {
  std::vector<size_t> group(rays.size());
  std::iota(group.begin(), group.end(), size_t{0});
  const auto root = [&](size_t i) {
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
  };
  std::vector<bool> proved(rays.size(), false);
  for (size_t i = 0; i < rays.size(); ++i) {
    if (rays[i].missed != kind) continue;
    size_t all = 0, missed = 0;
    grid.each_within(rays[i].hit_mm, [&](size_t k) {
      ++all;
      missed += rays[k].missed == kind;
    });
    if (missed < kLeastRays || static_cast<double>(missed) < kLeastShare * static_cast<double>(all)) continue;
    grid.each_within(rays[i].hit_mm, [&](size_t k) {
      if (rays[k].missed != kind) return;
      proved[k] = true;
      const size_t a = root(i), b = root(k);
      group[std::max(a, b)] = std::min(a, b);
    });
  }
  std::map<size_t, std::vector<size_t>> members;  // by the lowest ray of the group
  for (size_t i = 0; i < rays.size(); ++i)
    if (proved[i]) members[root(i)].push_back(i);
  for (const auto& [first, indices] : members) {
    MaterialFault fault;
    fault.missing = kind < 0;
    fault.face = face_id;
    fault.rays = indices.size();
    std::vector<double> depth;
    for (const size_t i : indices) {
      fault.point_mm += rays[i].hit_mm / static_cast<double>(indices.size());
      depth.push_back(rays[i].depth_mm);
    }
    std::nth_element(depth.begin(), depth.begin() + static_cast<std::ptrdiff_t>(depth.size() / 2),
                     depth.end());
    fault.depth_mm = depth[depth.size() / 2];
    inspection.material_faults.push_back(fault);
  }
}

}  // namespace

void find_material_faults(const Solid& model, const JoinedScan& joined,
                          const std::vector<FaceOutline>& outlines, const Tolerances& tolerances,
                          Inspection& inspection) {
  if (!joined.is_determined) return;
  const CastScan& cast = joined.cast;
  std::vector<std::vector<uint32_t>> rays_of_face(model.faces().size());
  for (uint32_t i = 0; i < cast.face.size(); ++i)
    if (cast.face[i] >= 0) rays_of_face[static_cast<size_t>(cast.face[i])].push_back(i);

  for (size_t k = 0; k < model.faces().size(); ++k) {
    const Face& face = model.faces()[k];
    const FaceTolerance tolerance = tolerances.of(face);
    if (!has_tolerance(tolerance) || tolerances.skip.contains(face.id)) continue;
    if (inspection.faces[k].verdict == Verdict::fail) continue;
    const double limit_mm = material_limit(tolerance);

    std::vector<Ray> rays;
    double sigma_mm = 0;
    for (const uint32_t i : rays_of_face[k]) {
      const int missed = beyond_limit(cast, i, limit_mm) <= 0 ? 0 : cast.beyond_mm[i] > 0 ? -1 : 1;
      rays.push_back({cast.hit_mm[i], std::abs(cast.deviation_mm[i]), missed});
      sigma_mm = std::max(sigma_mm, cast.sigma_mm[i]);
    }
    for (const uint32_t i : beyond_its_edge(model, joined, face, tolerances, limit_mm)) {
      const double depth_mm = cast.face[i] < 0 ? 0 : std::abs(cast.beyond_mm[i]);
      rays.push_back({cast.points_mm[i], depth_mm, 1});
    }
    if (rays.size() < kLeastRays) continue;
    const double spacing_mm = spacing_of(rays);
    if (!(spacing_mm > 0)) continue;
    if (inspection.faces[k].measured)
      inspection.smallest_feature_mm =
          std::max(inspection.smallest_feature_mm, kFeatureSpacings * spacing_mm);
    // At an edge the pose's own error and the spot's size decide what a ray meets.
    const double margin_mm = std::max(spacing_mm, 3 * sigma_mm);
    const PointGrid edge(samples_along(outlines[k], 0.5 * margin_mm), margin_mm);
    std::erase_if(rays, [&](const Ray& ray) { return edge.any_within(ray.hit_mm, margin_mm); });
    const RayGrid grid(rays, kWindowSpacings * spacing_mm);
    add_faults(rays, grid, -1, face.id, inspection);
    add_faults(rays, grid, +1, face.id, inspection);
  }
}

}  // namespace tetragauge
