// SPDX-License-Identifier: GPL-3.0-or-later
// An exact walk along a straight line through tetrahedra.
//
// Every decision is the sign of an orientation determinant of input points (CGAL's filtered exact
// predicates): no tolerance, no constructed point. The line may run through vertices, through edges, and
// along edges and facets; each such passage is a case of its own (vertex, edge, facet), never a perturbation.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reconstruct/tetrahedra.hpp"

namespace tetragauge {

struct WalkStep {
  uint32_t cell = kNoCell;  // whose interior the line enters; the last one may be infinite
  // Through which facet of the cell before it the line came (index there); -1: through an edge or a vertex,
  // or it is the first step.
  int facet_of_previous = -1;
};

struct Walk {
  enum class End {
    reached_target,  // the target lies in the last cell, closed
    left_hull,       // the last cell is infinite (kNoCell: the line left along the hull's boundary)
    lost             // cannot happen with exact predicates; counted, never ignored
  } end = End::lost;
  std::vector<WalkStep> steps;  // cells whose interior the line crosses, in order
  uint32_t end_cell = kNoCell;  // a finite cell containing the target, or the infinite cell left into
};

// Keeps scratch memory between walks, little of it; one per thread. Walks from one vertex after each other
// are cheaper than in mixed order: its star is kept.
class RayWalker {
 public:
  explicit RayWalker(const Tetrahedra& tetrahedra);

  // From vertex `start` towards `target`. The walk leaves from the vertex's star: a walk that ends without
  // `lost` is the certificate that the ray target -> vertex arrives.
  void walk(uint32_t start, const Vec3& target, Walk& walk);

 private:
  // Where the line stands between two steps: on a vertex, inside an edge, or inside a facet of `cell`.
  struct Feature {
    enum class Kind { vertex, edge, facet } kind = Kind::vertex;
    uint32_t a = 0, b = 0;  // vertex a; edge a b
    uint32_t cell = 0;      // vertex, edge: a finite cell at it; facet: the cell to enter
    int entry = 0;          // facet: its index in that cell
  };

  // Cells met so far while a star is collected: an open hash table, since stars are small and cells many.
  class CellSet {
   public:
    void clear();
    bool insert(uint32_t c);  // whether it is new

   private:
    void grow();
    std::vector<std::pair<uint32_t, uint32_t>> slots_ = std::vector<std::pair<uint32_t, uint32_t>>(128);
    uint32_t round_ = 0;  // slots of earlier rounds are empty
    size_t used_ = 0;
  };

  const Vec3& point(uint32_t v) const { return tetrahedra_.vertices[v]; }
  const Cell& cell(uint32_t c) const { return tetrahedra_.cells[c]; }
  int side(const Cell& c, int facet, const Vec3& x) const;
  bool target_is_before(const Cell& c, int exit) const { return may_stop_ && side(c, exit, t_) >= 0; }
  void collect_star(uint32_t a, uint32_t b, uint32_t from, std::vector<uint32_t>& star);
  void from_vertex();
  void from_edge();
  void from_facet();
  void along_facet(uint32_t index, int iu, int iw, int off);
  void enter(uint32_t c, int facet_of_previous) { walk_->steps.push_back({c, facet_of_previous}); }
  void cross(uint32_t c, int exit);
  void leave_hull(const std::vector<uint32_t>& star);
  void stop_in(uint32_t c);
  void lose() { done_ = true; }

  const Tetrahedra& tetrahedra_;
  Vec3 s_, t_;  // the line, start and target
  Walk* walk_ = nullptr;
  Feature at_;
  bool done_ = false;
  bool may_stop_ = true;  // false: the target is certainly outside the hull
  Vec3 low_, high_;       // box of all vertices
  std::vector<uint32_t> star_, edge_star_;
  uint32_t star_of_ = kInfiniteVertex;  // whose star stands in star_
  CellSet met_;
};

}  // namespace tetragauge
