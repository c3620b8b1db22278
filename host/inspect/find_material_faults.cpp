// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/find_material_faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "host/inspect/decide.hpp"
#include "host/inspect/point_grid.hpp"

namespace tetragauge {
namespace {

constexpr size_t kLeastRays = 8;
constexpr double kLeastShare =
    0.6;  // mixed points along a silhouette are a minority of a window, a feature fills it
constexpr double kWindowSpacings = 2;

// One ray that meets the face of the model: where, and how it missed.
struct Ray {
  Vec3 hit_mm;
  double depth_mm = 0;  // to the face's surface, + = stopped short of it
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
      depth.push_back(std::abs(rays[i].depth_mm));
    }
    std::nth_element(depth.begin(), depth.begin() + static_cast<std::ptrdiff_t>(depth.size() / 2),
                     depth.end());
    fault.depth_mm = depth[depth.size() / 2];
    inspection.material_faults.push_back(fault);
  }
}

}  // namespace

void find_material_faults(const Solid& model, const CastScan& cast, const std::vector<FaceOutline>& outlines,
                          const Tolerances& tolerances, Inspection& inspection) {
  if (!inspection.match.undetermined.empty()) return;
  std::vector<std::vector<uint32_t>> rays_of_face(model.faces().size());
  for (uint32_t i = 0; i < cast.face.size(); ++i)
    if (cast.face[i] >= 0) rays_of_face[static_cast<size_t>(cast.face[i])].push_back(i);

  for (size_t k = 0; k < model.faces().size(); ++k) {
    const Face& face = model.faces()[k];
    const FaceTolerance tolerance = tolerances.of(face);
    if (!has_tolerance(tolerance) || tolerances.skip.contains(face.id)) continue;
    if (inspection.faces[k].verdict == Verdict::fail || rays_of_face[k].size() < kLeastRays) continue;
    double limit_mm = tolerance.flatness_mm.value_or(1e300);
    limit_mm = std::min(limit_mm, offset_limit(tolerance));

    const double seen_mm2 = face.area_mm2 * std::max(0.1, inspection.faces[k].coverage);
    const double spacing_mm = std::sqrt(seen_mm2 / static_cast<double>(rays_of_face[k].size()));
    // At an edge the pose's own error and the spot's size decide what a ray meets.
    const double margin_mm = std::max(spacing_mm, 3 * cast.sigma_mm[rays_of_face[k].front()]);
    const PointGrid edge(samples_along(outlines[k], 0.5 * margin_mm), margin_mm);
    std::vector<Ray> rays;
    for (const uint32_t i : rays_of_face[k]) {
      if (edge.any_within(cast.hit_mm[i], margin_mm)) continue;
      const double off_mm = std::abs(cast.deviation_mm[i]) - (limit_mm + 3 * cast.sigma_mm[i]);
      const int missed = off_mm <= 0 ? 0 : cast.beyond_mm[i] > 0 ? -1 : 1;
      rays.push_back({cast.hit_mm[i], cast.deviation_mm[i], missed});
    }
    const RayGrid grid(rays, kWindowSpacings * spacing_mm);
    add_faults(rays, grid, -1, face.id, inspection);
    add_faults(rays, grid, +1, face.id, inspection);
  }
}

}  // namespace tetragauge
