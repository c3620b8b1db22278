// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/label_cells.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "host/reconstruct/minimum_cut.hpp"

namespace tetragauge {
namespace {

double facet_area(const Tetrahedra& tetrahedra, const Cell& cell, int i) {
  const auto& f = kFacet[static_cast<size_t>(i)];
  const Vec3& a = tetrahedra.vertices[cell.vertex[f[0]]];
  return 0.5 * (tetrahedra.vertices[cell.vertex[f[1]]] - a)
                   .cross(tetrahedra.vertices[cell.vertex[f[2]]] - a)
                   .norm();
}

// What a facet costs for its area alone. 0 between two infinite cells.
Votes area_cost(const Tetrahedra& tetrahedra, uint32_t c, int i, double cost_per_mm2) {
  // From the cell of the lower number, so that both see the same rounding.
  const uint32_t n = tetrahedra.cells[c].neighbour[static_cast<size_t>(i)];
  bool from_c = c < n;
  if (tetrahedra.cells[c].is_infinite()) {
    if (tetrahedra.cells[c].vertex[static_cast<size_t>(i)] != kInfiniteVertex) return 0;
    from_c = false;
  } else if (tetrahedra.cells[n].is_infinite()) {
    from_c = true;
  }
  const double area = from_c ? facet_area(tetrahedra, tetrahedra.cells[c], i)
                             : facet_area(tetrahedra, tetrahedra.cells[n], tetrahedra.mirror_index(c, i));
  return std::lround(std::min(1e6, cost_per_mm2 * area));
}

}  // namespace

std::vector<uint8_t> label_cells(const Tetrahedra& tetrahedra, const Visibility& visibility,
                                 double point_area_mm2) {
  const double cost_per_mm2 = 0.01 * static_cast<double>(kOneRay) / point_area_mm2;
  const size_t cells = tetrahedra.cells.size();
  CutProblem problem;
  problem.for_air.resize(cells);
  problem.cost.resize(cells);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, cells, 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t at = range.begin(); at < range.end(); ++at) {
      const auto c = static_cast<uint32_t>(at);
      const CellVotes& votes = visibility.cells[c];
      // One vote of a thousandth of a ray makes an infinite cell air by default.
      problem.for_air[c] =
          votes.from_outside + (tetrahedra.cells[c].is_infinite() ? 1 : 0) - votes.into_inside;
      for (int i = 0; i < 4; ++i) {
        const auto k = static_cast<size_t>(i);
        problem.cost[c][k] = votes.entered_through[k] + area_cost(tetrahedra, c, i, cost_per_mm2);
      }
    }
  });
  return minimum_cut(tetrahedra, std::move(problem));
}

}  // namespace tetragauge
