// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/reconstruct.hpp"

#include <cmath>

#include "host/reconstruct/average_points.hpp"
#include "host/reconstruct/carve_cells.hpp"
#include "host/reconstruct/extract_surface.hpp"
#include "host/reconstruct/find_supports.hpp"
#include "host/reconstruct/label_cells.hpp"
#include "host/reconstruct/mass_properties.hpp"
#include "host/reconstruct/rank_doubtful.hpp"
#include "host/reconstruct/tetrahedra.hpp"
#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {
namespace {

Status check(const Scan& scan, const ReconstructOptions& options) {
  const size_t n = scan.size();
  if (!(options.spacing_mm >= 0) || !std::isfinite(options.spacing_mm))
    return usage_error("reconstruct: the spacing of the vertices must be 0 (automatic) or a length in mm");
  if (options.model && options.method != ReconstructMethod::carve)
    return usage_error("reconstruct: a model is for the method carve; leave it out, or choose that method");
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

// The finite cells, in order; the ranked ones get their places in that list.
std::vector<LabelledTetrahedron> labelled(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                                          const Visibility& visibility,
                                          const std::vector<DoubtfulTetrahedron>& doubtful) {
  std::vector<LabelledTetrahedron> result;
  result.reserve(tetrahedra.cells.size());
  for (size_t c = 0; c < tetrahedra.cells.size(); ++c) {
    if (tetrahedra.cells[c].is_infinite()) continue;
    const CellVotes& votes = visibility.cells[c];
    result.push_back({tetrahedra.cells[c].vertex, air[c] != 0, false, cell_confidence(votes, air[c] != 0),
                      static_cast<float>(votes.air) / kOneRay, static_cast<float>(votes.solid) / kOneRay});
  }
  for (const DoubtfulTetrahedron& d : doubtful) result[d.cell].is_doubtful = true;
  return result;
}

std::vector<uint8_t> label(const Tetrahedra& tetrahedra, const Visibility& visibility,
                           const AveragedPoints& averaged, const ReconstructOptions& options) {
  return options.method == ReconstructMethod::cut
             ? label_cells(tetrahedra, visibility, averaged.point_spacing_mm * averaged.point_spacing_mm)
             : carve_cells(tetrahedra, visibility, averaged, options.model);
}

struct LabelledCells {
  Tetrahedra tetrahedra;
  Visibility visibility;
  std::vector<uint8_t> air;
};

// With supports added to `averaged` where they are needed.
Result<LabelledCells> label(const Scan& scan, AveragedPoints& averaged, const ReconstructOptions& options) {
  DelaunayTriangulation triangulation;
  triangulation.add(averaged.vertices);
  Result<Tetrahedra> tetrahedra = triangulation.tetrahedra();
  if (!tetrahedra) return tetrahedra.error();
  Visibility visibility = vote_visibility(*tetrahedra, scan, averaged);
  std::vector<uint8_t> air = label(*tetrahedra, visibility, averaged, options);
  constexpr int kRounds = 3;  // the first mends nearly all; new tetrahedra may show a few more
  for (int round = 0; round < kRounds && options.method == ReconstructMethod::cut; ++round) {
    const size_t vertices = averaged.vertices.size();
    add_supports(find_supports(*tetrahedra, air, visibility, averaged), averaged);
    if (averaged.vertices.size() == vertices) break;
    triangulation.add(std::span(averaged.vertices).subspan(vertices));
    Result<Tetrahedra> more = triangulation.tetrahedra();
    if (!more) return more.error();
    visibility = vote_again(*more, scan, averaged, *tetrahedra, visibility);
    tetrahedra = std::move(more);
    air = label(*tetrahedra, visibility, averaged, options);
  }
  return LabelledCells{*std::move(tetrahedra), std::move(visibility), std::move(air)};
}

}  // namespace

Result<Reconstruction> reconstruct(const Scan& scan, const ReconstructOptions& options) {
  if (Status status = check(scan, options); !status) return status.error();
  AveragedPoints averaged = average_points(scan, options.spacing_mm);
  const Result<LabelledCells> labels = label(scan, averaged, options);
  if (!labels) return labels.error();
  const auto& [tetrahedra, visibility, air] = *labels;

  Reconstruction result;
  Surface surface = extract_surface(tetrahedra, air, visibility, scan, averaged);
  result.doubtful_ranked = rank_doubtful(tetrahedra, air, visibility, surface);
  result.doubtful = result.doubtful_ranked.size();
  if (options.keep_tetrahedra) result.cells = labelled(tetrahedra, air, visibility, result.doubtful_ranked);
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
