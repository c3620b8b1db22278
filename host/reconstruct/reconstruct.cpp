// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/reconstruct.hpp"

#include <cmath>

#include "host/reconstruct/average_points.hpp"
#include "host/reconstruct/extract_surface.hpp"
#include "host/reconstruct/label_cells.hpp"
#include "host/reconstruct/mass_properties.hpp"
#include "host/reconstruct/tetrahedra.hpp"
#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {
namespace {

Status check(const Scan& scan, const ReconstructOptions& options) {
  const size_t n = scan.size();
  if (!(options.spacing_mm >= 0) || !std::isfinite(options.spacing_mm))
    return usage_error("reconstruct: the spacing of the vertices must be 0 (automatic) or a length in mm");
  if (n < 4)
    return bad_input("the scan has " + std::to_string(n) +
                     " points; tetrahedra need at least 4: scan more of the part");
  if (scan.ray_origins.size() != n || scan.sigma_mm.size() != n)
    return internal_error("the scan's arrays differ in length");
  for (size_t i = 0; i < n; ++i) {
    const std::string which = "point " + std::to_string(i) + " of the scan ";
    if (!scan.points[i].allFinite() || !scan.ray_origins[i].allFinite())
      return bad_input(which + "has a coordinate that is not a number: repair or remove it");
    if (!(scan.sigma_mm[i] >= 0) || !std::isfinite(scan.sigma_mm[i]))
      return bad_input(which + "has no valid sigma: give one with --sigma");
    if (scan.points[i] == scan.ray_origins[i])
      return bad_input(which +
                       "lies where its own ray begins: its ray has no direction; correct the ray's origin");
  }
  return Done{};
}

// Cells at the surface that their rays contradict, and solid no ray speaks about behind surface no ray has
// touched: filling, not knowledge.
size_t count_doubtful(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                      const Visibility& visibility, const Surface& surface) {
  std::vector<uint8_t> unseen(tetrahedra.cells.size(), 0);
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    if (surface.triangles[t].unseen) unseen[surface.solid_cell[t]] = 1;
  }
  size_t doubtful = 0;
  for (size_t c = 0; c < tetrahedra.cells.size(); ++c) {
    const Cell& cell = tetrahedra.cells[c];
    if (cell.is_infinite()) continue;
    bool at_surface = false;
    for (uint32_t n : cell.neighbour) at_surface = at_surface || air[n] != air[c];
    const CellVotes& votes = visibility.cells[c];
    const Votes for_it = air[c] ? votes.air : votes.solid, all = votes.air + votes.solid;
    if (at_surface && (all > 0 ? 4 * for_it < 3 * all : unseen[c] != 0)) ++doubtful;
  }
  return doubtful;
}

}  // namespace

Result<Reconstruction> reconstruct(const Scan& scan, const ReconstructOptions& options) {
  if (Status status = check(scan, options); !status) return status.error();
  AveragedPoints averaged = average_points(scan, options.spacing_mm);
  Result<Tetrahedra> triangulated = delaunay(averaged.vertices);
  if (!triangulated) return triangulated.error();
  const Tetrahedra& tetrahedra = *triangulated;

  const Visibility visibility = vote_visibility(tetrahedra, scan, averaged);
  const std::vector<uint8_t> air = label_cells(tetrahedra, visibility, options.method,
                                               averaged.point_spacing_mm * averaged.point_spacing_mm);

  Reconstruction result;
  Surface surface = extract_surface(tetrahedra, air, visibility, scan, averaged);
  result.doubtful = count_doubtful(tetrahedra, air, visibility, surface);
  result.surface = std::move(surface.triangles);
  result.closed = is_closed(result.surface);
  result.rays_walked = visibility.rays_walked;
  result.rays_lost = visibility.rays_lost;
  for (size_t c = 0; c < tetrahedra.cells.size(); ++c) {
    if (!tetrahedra.cells[c].is_infinite()) ++(air[c] ? result.air : result.solid);
  }
  result.tetrahedra = result.air + result.solid;

  const MassProperties mass = mass_properties(tetrahedra, air);
  result.volume_mm3 = mass.volume_mm3;
  result.centroid_mm = mass.centroid_mm;
  result.inertia_mm5 = mass.inertia_mm5;
  for (const SurfaceTriangle& t : result.surface) {
    if (t.unseen) continue;
    const Vec3& a = averaged.vertices[t.vertex[0]];
    const Vec3 ab = averaged.vertices[t.vertex[1]] - a, ac = averaged.vertices[t.vertex[2]] - a;
    result.area_mm2 += 0.5 * ab.cross(ac).norm();
  }

  result.vertex_spacing_mm = averaged.vertex_spacing_mm;
  result.point_spacing_mm = averaged.point_spacing_mm;
  result.vertices = std::move(averaged.vertices);
  result.vertex_sigma_mm = std::move(averaged.sigma_mm);
  result.vertex_ray = std::move(averaged.ray);
  result.point_vertex = std::move(averaged.point_vertex);
  return result;
}

}  // namespace tetragauge
