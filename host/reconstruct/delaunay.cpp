// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>

#include "host/reconstruct/tetrahedra.hpp"

namespace tetragauge {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<uint32_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<uint32_t, Kernel,
                                                           CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Triangulation =
    CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

// The even permutation that brings the lowest vertex to the front and the lowest of the others behind it: the
// cell keeps its orientation. Entry k: where corner k was.
std::array<int, 4> canonical_turn(const std::array<uint32_t, 4>& corners) {
  static constexpr std::array<std::array<int, 3>, 4> kOthers = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  const auto front = std::min_element(corners.begin(), corners.end()) - corners.begin();
  const std::array<int, 3>& others = kOthers[static_cast<size_t>(front)];
  size_t second = 0;
  for (size_t k = 1; k < 3; ++k) {
    if (corners[static_cast<size_t>(others[k])] < corners[static_cast<size_t>(others[second])]) second = k;
  }
  return {static_cast<int>(front), others[second], others[(second + 1) % 3], others[(second + 2) % 3]};
}

// The cells as CGAL has them, each turned, in CGAL's order.
std::vector<Cell> copy_cells(const Triangulation& triangulation) {
  uint32_t count = 0;
  for (auto c = triangulation.all_cells_begin(); c != triangulation.all_cells_end(); ++c) c->info() = count++;
  std::vector<Cell> cells(count);
  for (auto c = triangulation.all_cells_begin(); c != triangulation.all_cells_end(); ++c) {
    std::array<uint32_t, 4> corners;
    for (int i = 0; i < 4; ++i) {
      const auto v = c->vertex(i);
      corners[static_cast<size_t>(i)] = triangulation.is_infinite(v) ? kInfiniteVertex : v->info();
    }
    const std::array<int, 4> from = canonical_turn(corners);
    Cell& cell = cells[c->info()];
    for (size_t k = 0; k < 4; ++k) {
      cell.vertex[k] = corners[static_cast<size_t>(from[k])];
      cell.neighbour[k] = c->neighbor(from[k])->info();
    }
  }
  return cells;
}

// Ordered by their vertices' numbers, so that CGAL's order of insertion does not show, and cells are as near
// in memory as their vertices are.
std::vector<Cell> sort_cells(const std::vector<Cell>& cells, size_t vertices) {
  std::vector<uint32_t> first(vertices + 1, 0);
  for (const Cell& cell : cells) ++first[cell.vertex[0] + 1];
  for (size_t v = 0; v < vertices; ++v) first[v + 1] += first[v];
  std::vector<uint32_t> order(cells.size()), next(first.begin(), first.end() - 1), number(cells.size());
  for (uint32_t c = 0; c < cells.size(); ++c) order[next[cells[c].vertex[0]]++] = c;
  tbb::parallel_for(size_t{0}, vertices, [&](size_t v) {
    std::sort(order.begin() + first[v], order.begin() + first[v + 1],
              [&](uint32_t a, uint32_t b) { return cells[a].vertex < cells[b].vertex; });
    for (uint32_t at = first[v]; at < first[v + 1]; ++at) number[order[at]] = at;
  });
  std::vector<Cell> sorted(cells.size());
  tbb::parallel_for(size_t{0}, cells.size(), [&](size_t c) {
    sorted[c] = cells[order[c]];
    for (uint32_t& n : sorted[c].neighbour) n = number[n];
  });
  return sorted;
}

// Where in `next` the vertex stands that `cell` does not have, across cell's facet i.
int find_mirror(const Cell& cell, size_t i, const Cell& next) {
  for (int j = 0; j < 4; ++j) {
    const int k = cell.index_of(next.vertex[static_cast<size_t>(j)]);
    if (k < 0 || k == static_cast<int>(i)) return j;
  }
  return -1;
}

// In rounds of growing size, each along the order of the points: random enough for speed (Amenta, Choi, Rote,
// SoCG 2003), and every point near the one before, as those of average_points are.
std::vector<uint32_t> insertion_order(size_t points) {
  constexpr int kRounds = 12;  // each has four times as many as the one before
  std::vector<std::vector<uint32_t>> rounds(kRounds);
  for (uint32_t i = 0; i < points; ++i) {
    uint32_t bits =
        (i + 1) * 2654435769u;  // Knuth's multiplicative hash, and its high bits over the low ones
    bits ^= bits >> 15;
    bits *= 2246822519u;
    bits ^= bits >> 13;
    const int round = kRounds - 1 - std::min(std::countr_zero(bits) / 2, kRounds - 1);
    rounds[static_cast<size_t>(round)].push_back(i);
  }
  std::vector<uint32_t> order;
  order.reserve(points);
  for (size_t k = 0; k < rounds.size(); ++k) {
    if (k % 2 == 1) std::reverse(rounds[k].begin(), rounds[k].end());  // to and fro
    order.insert(order.end(), rounds[k].begin(), rounds[k].end());
  }
  return order;
}

}  // namespace

size_t Tetrahedra::finite_cells() const {
  return static_cast<size_t>(
      std::count_if(cells.begin(), cells.end(), [](const Cell& c) { return !c.is_infinite(); }));
}

struct DelaunayTriangulation::State {
  Triangulation triangulation;
  std::vector<Vec3> points;
};

DelaunayTriangulation::DelaunayTriangulation() : state_(std::make_unique<State>()) {}
DelaunayTriangulation::DelaunayTriangulation(DelaunayTriangulation&&) noexcept = default;
DelaunayTriangulation& DelaunayTriangulation::operator=(DelaunayTriangulation&&) noexcept = default;
DelaunayTriangulation::~DelaunayTriangulation() = default;

void DelaunayTriangulation::add(std::span<const Vec3> points) {
  const auto before = static_cast<uint32_t>(state_->points.size());
  state_->points.insert(state_->points.end(), points.begin(), points.end());
  Triangulation::Vertex_handle near;
  for (const uint32_t i : insertion_order(points.size())) {
    near = state_->triangulation.insert(Kernel::Point_3(points[i].x(), points[i].y(), points[i].z()), near);
    near->info() = before + i;
  }
}

Result<Tetrahedra> DelaunayTriangulation::tetrahedra() const {
  const std::vector<Vec3>& points = state_->points;
  if (points.size() < 4)
    return bad_input("the scan has " + std::to_string(points.size()) +
                     " distinct points; tetrahedra need at least 4: scan more of the part");
  if (state_->triangulation.dimension() < 3)
    return bad_input(
        "all points of the scan lie exactly in one plane or on one line: they enclose nothing; scan from "
        "another view, or fit the plane directly");
  Tetrahedra result;
  result.vertices = points;
  result.cells = sort_cells(copy_cells(state_->triangulation), points.size());
  result.mirror.assign(result.cells.size(), 0);
  result.vertex_cell.assign(points.size(), kNoCell);
  tbb::parallel_for(size_t{0}, result.cells.size(), [&](size_t c) {
    const Cell& cell = result.cells[c];
    int mirror = 0;
    for (size_t i = 0; i < 4; ++i) mirror |= find_mirror(cell, i, result.cells[cell.neighbour[i]]) << (2 * i);
    result.mirror[c] = static_cast<uint8_t>(mirror);
  });
  for (uint32_t c = 0; c < result.cells.size(); ++c) {
    const Cell& cell = result.cells[c];
    if (cell.is_infinite()) continue;
    for (uint32_t v : cell.vertex) {
      if (result.vertex_cell[v] == kNoCell) result.vertex_cell[v] = c;
    }
  }
  return result;
}

Result<Tetrahedra> delaunay(std::span<const Vec3> points) {
  DelaunayTriangulation triangulation;
  triangulation.add(points);
  return triangulation.tetrahedra();
}

}  // namespace tetragauge
