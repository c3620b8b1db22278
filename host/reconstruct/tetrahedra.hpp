// SPDX-License-Identifier: GPL-3.0-or-later
// Delaunay tetrahedra as flat arrays: what the ray walk, the cut and the surface work on.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "host/base/result.hpp"
#include "host/geometry/vec.hpp"

namespace tetragauge {

constexpr uint32_t kInfiniteVertex = UINT32_MAX;
constexpr uint32_t kNoCell = UINT32_MAX;

// Finite cells are positively oriented: det(v1 - v0, v2 - v0, v3 - v0) > 0. An infinite cell stands on each
// facet of the convex hull and has kInfiniteVertex as one of its vertices.
struct Cell {
  std::array<uint32_t, 4> vertex;
  std::array<uint32_t, 4> neighbour;  // across the facet opposite vertex i

  bool is_infinite() const {
    return vertex[0] == kInfiniteVertex || vertex[1] == kInfiniteVertex || vertex[2] == kInfiniteVertex ||
           vertex[3] == kInfiniteVertex;
  }
  int index_of(uint32_t v) const {  // -1: not a vertex of this cell
    for (int i = 0; i < 4; ++i) {
      if (vertex[static_cast<size_t>(i)] == v) return i;
    }
    return -1;
  }
};

// The three vertices of facet i (opposite vertex i), in the order that makes orient(a, b, c, v_i) positive:
// counter-clockwise seen from v_i.
constexpr std::array<std::array<uint8_t, 3>, 4> kFacet = {{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};

struct Tetrahedra {
  std::vector<Vec3> vertices;         // mm
  std::vector<Cell> cells;            // finite and infinite
  std::vector<uint32_t> vertex_cell;  // one finite cell at each vertex
  std::vector<uint8_t> mirror;        // per cell four times two bits, see mirror_index

  size_t finite_cells() const;
  // Index, in the neighbour across facet i of cell c, of the vertex opposite that facet.
  int mirror_index(uint32_t c, int i) const { return (mirror[c] >> (2 * i)) & 3; }
};

// Delaunay tetrahedra of distinct points, with exact predicates (CGAL); cospherical sets are resolved by
// CGAL's symbolic perturbation, so the result depends on the points alone. Error (bad input): fewer than 4
// points, or all of them in one plane.
Result<Tetrahedra> delaunay(std::span<const Vec3> points);

// The same, to which more points can be added.
class DelaunayTriangulation {
 public:
  DelaunayTriangulation();
  DelaunayTriangulation(DelaunayTriangulation&&) noexcept;
  DelaunayTriangulation& operator=(DelaunayTriangulation&&) noexcept;
  ~DelaunayTriangulation();

  // Numbered on from those before; distinct from them and from one another. Fast if neighbours in the list
  // are near in space.
  void add(std::span<const Vec3> points);
  Result<Tetrahedra> tetrahedra() const;

 private:
  struct State;  // CGAL's
  std::unique_ptr<State> state_;
};

}  // namespace tetragauge
