// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/rank_doubtful.hpp"

#include <algorithm>

namespace tetragauge {
namespace {

// Twice its area, out of finite cell c through facet i.
Vec3 outward_normal(const Tetrahedra& tetrahedra, const Cell& cell, size_t i) {
  const auto& f = kFacet[i];
  const Vec3& a = tetrahedra.vertices[cell.vertex[f[0]]];
  return (tetrahedra.vertices[cell.vertex[f[2]]] - a).cross(tetrahedra.vertices[cell.vertex[f[1]]] - a);
}

// Whether facet i of finite cell c is surface: solid that reaches the hull ends there, whatever beyond it
// claims.
bool is_surface(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air, uint32_t c, size_t i) {
  const uint32_t n = tetrahedra.cells[c].neighbour[i];
  return air[n] != air[c] || (!air[c] && tetrahedra.cells[n].is_infinite());
}

// `unseen`: sum of the normals of the surface on it that no ray has touched.
DoubtfulTetrahedron describe(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air, uint32_t c,
                             const Vec3& unseen) {
  const Cell& cell = tetrahedra.cells[c];
  DoubtfulTetrahedron result;
  Vec3 to_air = Vec3::Zero();
  for (size_t i = 0; i < 4; ++i) {
    result.centroid_mm += 0.25 * tetrahedra.vertices[cell.vertex[i]];
    if (!is_surface(tetrahedra, air, c, i)) continue;
    const Vec3 outward = outward_normal(tetrahedra, cell, i);
    result.face_area_mm2 += 0.5 * outward.norm();
    to_air += air[c] ? Vec3(-outward) : outward;
  }
  const Vec3& a = tetrahedra.vertices[cell.vertex[0]];
  result.volume_mm3 = (tetrahedra.vertices[cell.vertex[1]] - a)
                          .cross(tetrahedra.vertices[cell.vertex[2]] - a)
                          .dot(tetrahedra.vertices[cell.vertex[3]] - a) /
                      6;
  if (unseen.norm() > 0) to_air = unseen;
  // Surface on both sides of a sliver may cancel: then along its widest facet on the surface.
  for (size_t i = 0; i < 4 && !(to_air.norm() > 1e-3 * result.face_area_mm2); ++i) {
    if (is_surface(tetrahedra, air, c, i)) to_air = outward_normal(tetrahedra, cell, i);
  }
  if (to_air.norm() > 0) result.look_from = to_air.normalized();
  return result;
}

// Surface that no ray has touched: the finite solid cell behind it, ascending, and its outward normal. Where
// an infinite cell was claimed solid too, the finite one is the one inside it.
std::vector<std::pair<uint32_t, Vec3>> find_unseen(const Tetrahedra& tetrahedra,
                                                   const std::vector<uint8_t>& air, const Surface& surface) {
  std::vector<std::pair<uint32_t, Vec3>> result;
  for (size_t k = 0; k < surface.triangles.size(); ++k) {
    const SurfaceTriangle& t = surface.triangles[k];
    if (!t.unseen) continue;
    uint32_t c = surface.solid_cell[k];
    const int beyond = tetrahedra.cells[c].index_of(kInfiniteVertex);
    if (beyond >= 0) c = tetrahedra.cells[c].neighbour[static_cast<size_t>(beyond)];
    if (air[c]) continue;
    const Vec3& a = tetrahedra.vertices[t.vertex[0]];
    result.emplace_back(c,
                        (tetrahedra.vertices[t.vertex[1]] - a).cross(tetrahedra.vertices[t.vertex[2]] - a));
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return result;
}

}  // namespace

float cell_confidence(const CellVotes& votes, bool is_air) {
  const Votes for_it = is_air ? votes.air : votes.solid, all = votes.air + votes.solid;
  return all > 0 ? static_cast<float>(static_cast<double>(for_it) / static_cast<double>(all)) : 0.f;
}

std::vector<DoubtfulTetrahedron> rank_doubtful(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                                               const Visibility& visibility, const Surface& surface) {
  const std::vector<std::pair<uint32_t, Vec3>> unseen_facets = find_unseen(tetrahedra, air, surface);
  std::vector<DoubtfulTetrahedron> result;
  uint32_t finite = 0;
  size_t facet = 0;
  for (uint32_t c = 0; c < tetrahedra.cells.size(); ++c) {
    const Cell& cell = tetrahedra.cells[c];
    Vec3 unseen = Vec3::Zero();
    for (; facet < unseen_facets.size() && unseen_facets[facet].first == c; ++facet)
      unseen += unseen_facets[facet].second;
    if (cell.is_infinite()) continue;
    const uint32_t place = finite++;
    bool at_surface = false;
    for (size_t i = 0; i < 4; ++i) at_surface = at_surface || is_surface(tetrahedra, air, c, i);
    if (!at_surface) continue;
    const CellVotes& votes = visibility.cells[c];
    const Votes for_it = air[c] ? votes.air : votes.solid, all = votes.air + votes.solid;
    if (unseen.isZero(0) && 4 * for_it >= 3 * all) continue;
    result.push_back(describe(tetrahedra, air, c, unseen));
    result.back().cell = place;
    result.back().is_air = air[c] != 0;
    result.back().confidence = cell_confidence(votes, air[c] != 0);
  }
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) {
    return std::pair(a.volume_mm3, a.face_area_mm2) > std::pair(b.volume_mm3, b.face_area_mm2);
  });
  return result;
}

}  // namespace tetragauge
