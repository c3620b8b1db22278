// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/find_supports.hpp"

#include <algorithm>
#include <set>
#include <tuple>

namespace tetragauge {
namespace {

// Facet i of a cell, seen from behind: its corners counter-clockwise, its normal the way the light went.
struct Facet {
  std::array<Vec3, 3> corner;
  Vec3 inwards;  // unit
  double longest_mm = 0, width_mm = 0;

  Facet(const Tetrahedra& tetrahedra, const Cell& cell, size_t i) {
    for (size_t k = 0; k < 3; ++k) corner[k] = tetrahedra.vertices[cell.vertex[kFacet[i][k]]];
    for (size_t k = 0; k < 3; ++k)
      longest_mm = std::max(longest_mm, (corner[(k + 1) % 3] - corner[k]).norm());
    const Vec3 twice_area = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    width_mm = twice_area.norm() / longest_mm;
    inwards = twice_area.normalized();
  }
};

bool is_measured(const Facet& facet, const Cell& cell, size_t i, const AveragedPoints& averaged) {
  constexpr double kGrazing = 0.05;  // sine of about 3 degrees, as where surface counts as touched
  const double spacing = averaged.vertex_spacing_mm;
  if (!(facet.longest_mm < 3 * spacing) || !(facet.width_mm > spacing / 4)) return false;
  return std::all_of(kFacet[i].begin(), kFacet[i].end(),
                     [&](uint8_t k) { return averaged.ray[cell.vertex[k]].dot(facet.inwards) > kGrazing; });
}

}  // namespace

std::vector<Vec3> find_supports(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                                const Visibility& visibility, const AveragedPoints& averaged) {
  std::vector<Vec3> supports;
  const double spacing = averaged.vertex_spacing_mm;
  for (uint32_t c = 0; c < tetrahedra.cells.size(); ++c) {
    const Cell& cell = tetrahedra.cells[c];
    if (!air[c] || cell.is_infinite()) continue;
    for (size_t i = 0; i < 4; ++i) {
      if (!air[cell.neighbour[i]] || visibility.cells[c].entered_through[i] >= kOneRay) continue;
      const Facet facet(tetrahedra, cell, i);
      const double depth = facet.inwards.dot(tetrahedra.vertices[cell.vertex[i]] - facet.corner[0]);
      if (!(depth > 2 * spacing) || !is_measured(facet, cell, i, averaged)) continue;
      const Vec3 middle = (facet.corner[0] + facet.corner[1] + facet.corner[2]) / 3;
      for (double d = spacing; 2 * d < depth; d *= 2) supports.push_back(middle + d * facet.inwards);
    }
  }
  return supports;
}

void add_supports(const std::vector<Vec3>& supports, AveragedPoints& averaged) {
  const auto coordinates = [](const Vec3& p) { return std::tuple(p.x(), p.y(), p.z()); };
  std::set<std::tuple<double, double, double>> wanted;
  for (const Vec3& p : supports) wanted.insert(coordinates(p));
  // Vertices are distinct: in exact grids a support may fall on one that is there.
  for (const Vec3& p : averaged.vertices) wanted.erase(coordinates(p));
  for (const Vec3& p : supports) {
    if (wanted.erase(coordinates(p)) == 0) continue;
    averaged.vertices.push_back(p);
    averaged.sigma_mm.push_back(static_cast<float>(averaged.vertex_spacing_mm));
    averaged.ray.push_back(Vec3::Zero());
  }
}

}  // namespace tetragauge
