// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/walk_ray.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>

namespace tetragauge {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 exact(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

int orient(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return static_cast<int>(CGAL::orientation(exact(a), exact(b), exact(c), exact(d)));
}

}  // namespace

void RayWalker::CellSet::clear() {
  used_ = 0;
  if (++round_ == 0) {  // after 2^32 rounds the oldest would count again
    std::fill(slots_.begin(), slots_.end(), std::pair<uint32_t, uint32_t>{});
    round_ = 1;
  }
}

bool RayWalker::CellSet::insert(uint32_t c) {
  if (2 * used_ >= slots_.size()) grow();
  const size_t mask = slots_.size() - 1;
  for (size_t at = (c * 2654435769u >> 7) & mask;; at = (at + 1) & mask) {
    if (slots_[at].second != round_) {
      slots_[at] = {c, round_};
      ++used_;
      return true;
    }
    if (slots_[at].first == c) return false;
  }
}

void RayWalker::CellSet::grow() {
  std::vector<std::pair<uint32_t, uint32_t>> old(2 * slots_.size());
  old.swap(slots_);
  used_ = 0;
  for (const auto& [c, round] : old) {
    if (round == round_) insert(c);
  }
}

RayWalker::RayWalker(const Tetrahedra& tetrahedra) : tetrahedra_(tetrahedra) {
  low_ = high_ = tetrahedra.vertices.front();
  for (const Vec3& p : tetrahedra.vertices) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
}

void RayWalker::walk(uint32_t start, const Vec3& target, Walk& walk) {
  s_ = point(start);
  t_ = target;
  may_stop_ = (low_.array() <= target.array()).all() && (target.array() <= high_.array()).all();
  walk_ = &walk;
  done_ = false;
  walk.end = Walk::End::lost;
  walk.end_cell = kNoCell;
  walk.steps.clear();
  at_ = {Feature::Kind::vertex, start, 0, tetrahedra_.vertex_cell[start], 0};
  if (s_ == t_) return stop_in(at_.cell);
  // Each step moves strictly forward on the line, so no cell, facet or edge comes twice.
  const size_t bound = 8 * tetrahedra_.cells.size() + 8;
  for (size_t step = 0; step < bound && !done_; ++step) {
    switch (at_.kind) {
      case Feature::Kind::vertex:
        from_vertex();
        break;
      case Feature::Kind::edge:
        from_edge();
        break;
      case Feature::Kind::facet:
        from_facet();
        break;
    }
  }
  if (!done_) walk.end = Walk::End::lost;
}

// Side of x against facet i of a finite cell: positive where the cell is.
int RayWalker::side(const Cell& c, int i, const Vec3& x) const {
  const auto& f = kFacet[static_cast<size_t>(i)];
  return orient(point(c.vertex[f[0]]), point(c.vertex[f[1]]), point(c.vertex[f[2]]), x);
}

void RayWalker::stop_in(uint32_t c) {
  walk_->end = Walk::End::reached_target;
  walk_->end_cell = c;
  done_ = true;
}
// Steps through facet `exit` of cell c.
void RayWalker::cross(uint32_t c, int exit) {
  const uint32_t next = cell(c).neighbour[static_cast<size_t>(exit)];
  enter(next, exit);
  if (cell(next).is_infinite()) {
    walk_->end = Walk::End::left_hull;
    walk_->end_cell = next;
    done_ = true;
    return;
  }
  at_ = {Feature::Kind::facet, 0, 0, next, tetrahedra_.mirror_index(c, exit)};
}

// Out of the hull through a vertex or an edge: into the infinite cell on a hull facet that the target sees.
void RayWalker::leave_hull(const std::vector<uint32_t>& star) {
  walk_->end = Walk::End::left_hull;
  done_ = true;
  for (uint32_t c : star) {
    const Cell& infinite = cell(c);
    const int i = infinite.index_of(kInfiniteVertex);
    if (i < 0) continue;
    const uint32_t inner = infinite.neighbour[static_cast<size_t>(i)];
    if (side(cell(inner), tetrahedra_.mirror_index(c, i), t_) < 0 && c < walk_->end_cell) walk_->end_cell = c;
  }
  if (walk_->end_cell != kNoCell) enter(walk_->end_cell, -1);
}

// All cells, finite and infinite, that have vertex a (and b, if it is another).
void RayWalker::collect_star(uint32_t a, uint32_t b, uint32_t from, std::vector<uint32_t>& star) {
  met_.clear();
  met_.insert(from);
  star.assign(1, from);
  for (size_t next = 0; next < star.size(); ++next) {
    const Cell& c = cell(star[next]);
    for (size_t i = 0; i < 4; ++i) {
      if (c.vertex[i] == a || c.vertex[i] == b) continue;
      if (met_.insert(c.neighbour[i])) star.push_back(c.neighbour[i]);
    }
  }
}

void RayWalker::from_vertex() {
  const uint32_t v = at_.a;
  if (star_of_ != v) collect_star(v, v, tetrahedra_.vertex_cell[v], star_);
  star_of_ = v;
  for (uint32_t index : star_) {
    const Cell& c = cell(index);
    if (c.is_infinite()) continue;
    const int apex = c.index_of(v);
    int zeros = 0, zero[3] = {}, others = 0, other = -1;
    bool inside = true;
    for (int i = 0; i < 4 && inside; ++i) {
      if (i == apex) continue;
      const int sign = side(c, i, t_);
      if (sign < 0) inside = false;
      if (sign == 0) zero[zeros++] = i;
      if (sign > 0) {
        ++others;
        other = i;
      }
    }
    if (!inside) continue;
    if (zeros == 0) {  // into the cell; it leaves through the facet opposite v
      enter(index, -1);
      if (target_is_before(c, apex)) return stop_in(index);
      return cross(index, apex);
    }
    if (zeros == 1) {  // within the facet opposite zero[0]; it leaves through that facet's edge opposite v
      uint32_t edge[2] = {};
      int n = 0;
      for (int i = 0; i < 4; ++i) {
        if (i != apex && i != zero[0]) edge[n++] = c.vertex[static_cast<size_t>(i)];
      }
      const Vec3& off = point(c.vertex[static_cast<size_t>(zero[0])]);
      const int of_v = orient(point(edge[0]), point(edge[1]), off, point(v));
      if (orient(point(edge[0]), point(edge[1]), off, t_) * of_v >= 0) return stop_in(index);
      at_ = {Feature::Kind::edge, edge[0], edge[1], index, 0};
      return;
    }
    if (zeros == 2 && others == 1) {  // along the edge to the vertex that is in both zero facets
      const uint32_t w = c.vertex[static_cast<size_t>(other)];
      if (CGAL::collinear_are_ordered_along_line(exact(point(v)), exact(t_), exact(point(w))))
        return stop_in(index);
      at_ = {Feature::Kind::vertex, w, 0, index, 0};
      return;
    }
    return lose();
  }
  leave_hull(star_);
}

void RayWalker::from_edge() {
  const uint32_t u = at_.a, w = at_.b;
  collect_star(u, w, at_.cell, edge_star_);
  for (uint32_t index : edge_star_) {
    const Cell& c = cell(index);
    if (c.is_infinite()) continue;
    int iu = c.index_of(u), iw = c.index_of(w);
    int rest[2] = {}, n = 0;
    for (int i = 0; i < 4; ++i) {
      if (i != iu && i != iw) rest[n++] = i;
    }
    // Facets through the edge are those opposite the other two vertices.
    const int sign_0 = side(c, rest[0], t_), sign_1 = side(c, rest[1], t_);
    if (sign_0 < 0 || sign_1 < 0) continue;
    if (sign_0 == 0 && sign_1 == 0) return lose();  // along its own edge: would have come from a vertex
    if (sign_0 == 0 || sign_1 == 0) return along_facet(index, iu, iw, sign_0 == 0 ? rest[0] : rest[1]);
    enter(index, -1);
    // With orient(u, w, a, b) > 0 the line leaves on w's far side when orient(s, t, a, b) < 0.
    int a = rest[0], b = rest[1];
    if (orient(point(u), point(w), point(c.vertex[static_cast<size_t>(a)]),
               point(c.vertex[static_cast<size_t>(b)])) < 0)
      std::swap(a, b);
    const uint32_t va = c.vertex[static_cast<size_t>(a)], vb = c.vertex[static_cast<size_t>(b)];
    const int sign = orient(s_, t_, point(va), point(vb));
    const int exit = sign > 0 ? iu : iw;
    if (target_is_before(c, exit)) return stop_in(index);
    if (sign == 0) {
      at_ = {Feature::Kind::edge, va, vb, index, 0};
      return;
    }
    return cross(index, exit);
  }
  leave_hull(edge_star_);
}

// From inside edge (iu, iw) of a cell along its facet opposite `off`.
void RayWalker::along_facet(uint32_t index, int iu, int iw, int off) {
  const Cell& c = cell(index);
  const int ia = 6 - iu - iw - off;
  const uint32_t u = c.vertex[static_cast<size_t>(iu)], w = c.vertex[static_cast<size_t>(iw)],
                 a = c.vertex[static_cast<size_t>(ia)];
  const Vec3& x = point(c.vertex[static_cast<size_t>(off)]);
  const int of_u = orient(s_, t_, point(u), x), of_a = orient(s_, t_, point(a), x);
  const uint32_t to = of_a == of_u ? w : u;  // the edge it leaves by (or touches at a) is (to, a)
  const uint32_t from = to == w ? u : w;
  const int of_from = orient(point(to), point(a), x, point(from));
  if (orient(point(to), point(a), x, t_) * of_from >= 0) return stop_in(index);
  if (of_a == 0)
    at_ = {Feature::Kind::vertex, a, 0, index, 0};
  else
    at_ = {Feature::Kind::edge, to, a, index, 0};
}

void RayWalker::from_facet() {
  const uint32_t index = at_.cell;
  const Cell& c = cell(index);
  const int apex = at_.entry;
  const auto& base = kFacet[static_cast<size_t>(apex)];
  const uint32_t d = c.vertex[static_cast<size_t>(apex)];
  // Seen against the line of travel the base a b c is counter-clockwise; the line leaves between d->a and
  // d->b when orient(s, t, a, d) < 0 < orient(s, t, b, d). Each sign is asked for only when it is needed.
  int sign[3] = {};
  bool known[3] = {};
  const auto sign_at = [&](size_t k) {
    if (!known[k]) sign[k] = orient(s_, t_, point(c.vertex[base[k]]), point(d));
    known[k] = true;
    return sign[k];
  };
  for (size_t k = 0; k < 3; ++k) {
    if (sign_at(k) < 0 && sign_at((k + 1) % 3) > 0) {
      const int exit = base[(k + 2) % 3];
      if (target_is_before(c, exit)) return stop_in(index);
      return cross(index, exit);
    }
  }
  for (size_t k = 0; k < 3; ++k) {
    if (sign_at(k) != 0) continue;
    if (target_is_before(c, base[(k + 1) % 3])) return stop_in(index);
    if (sign_at((k + 1) % 3) == 0 && sign_at((k + 2) % 3) == 0)
      at_ = {Feature::Kind::vertex, d, 0, index, 0};
    else
      at_ = {Feature::Kind::edge, c.vertex[base[k]], d, index, 0};
    return;
  }
  lose();
}

}  // namespace tetragauge
