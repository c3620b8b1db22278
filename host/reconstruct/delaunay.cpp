// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>

#include "host/reconstruct/tetrahedra.hpp"

namespace tetragauge {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<uint32_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<uint32_t, Kernel,
                                                           CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Triangulation =
    CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

}  // namespace

size_t Tetrahedra::finite_cells() const {
  return static_cast<size_t>(
      std::count_if(cells.begin(), cells.end(), [](const Cell& c) { return !c.is_infinite(); }));
}

int Tetrahedra::mirror_index(uint32_t c, int i) const {
  const Cell& cell = cells[c];
  const Cell& next = cells[cell.neighbour[static_cast<size_t>(i)]];
  for (int j = 0; j < 4; ++j) {
    const int k = cell.index_of(next.vertex[static_cast<size_t>(j)]);
    if (k < 0 || k == i) return j;
  }
  return -1;
}

Result<Tetrahedra> delaunay(std::span<const Vec3> points) {
  if (points.size() < 4)
    return bad_input("the scan has " + std::to_string(points.size()) +
                     " distinct points; tetrahedra need at least 4: scan more of the part");
  std::vector<std::pair<Kernel::Point_3, uint32_t>> numbered;
  numbered.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    numbered.emplace_back(Kernel::Point_3(points[i].x(), points[i].y(), points[i].z()),
                          static_cast<uint32_t>(i));
  Triangulation triangulation(numbered.begin(), numbered.end());
  if (triangulation.dimension() < 3)
    return bad_input(
        "all points of the scan lie exactly in one plane or on one line: they enclose nothing; scan from "
        "another view, or fit the plane directly");

  Tetrahedra result;
  result.vertices.assign(points.begin(), points.end());
  result.vertex_cell.assign(points.size(), kNoCell);
  uint32_t count = 0;
  for (auto c = triangulation.all_cells_begin(); c != triangulation.all_cells_end(); ++c) c->info() = count++;
  result.cells.resize(count);
  for (auto c = triangulation.all_cells_begin(); c != triangulation.all_cells_end(); ++c) {
    Cell& cell = result.cells[c->info()];
    for (int i = 0; i < 4; ++i) {
      const auto v = c->vertex(i);
      const auto k = static_cast<size_t>(i);
      cell.vertex[k] = triangulation.is_infinite(v) ? kInfiniteVertex : v->info();
      cell.neighbour[k] = c->neighbor(i)->info();
    }
    if (!cell.is_infinite()) {
      for (uint32_t v : cell.vertex) {
        if (result.vertex_cell[v] == kNoCell) result.vertex_cell[v] = c->info();
      }
    }
  }
  return result;
}

}  // namespace tetragauge
