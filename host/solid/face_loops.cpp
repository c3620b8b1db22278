// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/face_loops.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace tetragauge {
namespace {

// Points of exact edges lie this near to their line or circle, and those of a mesh to this share of the
// part's extent, within which close_mesh takes corners for one. What a file's own tolerance has let further
// off is a curve.
constexpr double kOnCurve_mm = 1e-5;
constexpr double kOnCurveShare = 1e-6;

constexpr size_t kNone = static_cast<size_t>(-1);

// Half-edge 3 i + k runs from corner k of triangle i to the next one.
class HalfEdges {
 public:
  explicit HalfEdges(const Solid& solid) : solid_(solid), twin_(3 * solid.triangles.size(), kNone) {
    std::vector<size_t> order(twin_.size());
    for (size_t h = 0; h < order.size(); ++h) order[h] = h;
    const auto ends = [&](size_t h) { return std::pair(std::min(from(h), to(h)), std::max(from(h), to(h))); };
    std::sort(order.begin(), order.end(),
              [&](size_t a, size_t b) { return std::tuple(ends(a), a) < std::tuple(ends(b), b); });
    for (size_t first = 0; first < order.size();) {
      size_t last = first;
      while (last < order.size() && ends(order[last]) == ends(order[first])) ++last;
      // More than two meet where bodies touch along an edge: those of one face belong together.
      pair_up(order, first, last, true);
      pair_up(order, first, last, false);
      first = last;
    }
  }

  size_t count() const { return twin_.size(); }
  uint32_t from(size_t h) const { return solid_.triangles[h / 3][h % 3]; }
  uint32_t to(size_t h) const { return from(after(h)); }
  uint32_t face(size_t h) const { return solid_.triangle_face[h / 3]; }
  int beyond(size_t h) const { return twin_[h] == kNone ? 0 : static_cast<int>(face(twin_[h])) + 1; }
  bool is_boundary(size_t h) const { return twin_[h] == kNone || face(twin_[h]) != face(h); }

  // The boundary half-edge of the same face that follows: the first one met when the face's triangles about
  // the end are turned through. It is met, for only h itself could lead back to where the turn began.
  size_t following(size_t h) const {
    size_t e = after(h);
    while (!is_boundary(e)) e = after(twin_[e]);
    return e;
  }

 private:
  static size_t after(size_t h) { return h % 3 == 2 ? h - 2 : h + 1; }

  void pair_up(const std::vector<size_t>& order, size_t first, size_t last, bool only_in_face) {
    for (size_t i = first; i < last; ++i) {
      for (size_t j = i + 1; j < last && twin_[order[i]] == kNone; ++j) {
        const size_t a = order[i], b = order[j];
        if (twin_[b] != kNone || from(a) != to(b) || (only_in_face && face(a) != face(b))) continue;
        twin_[a] = b;
        twin_[b] = a;
      }
    }
  }

  const Solid& solid_;
  std::vector<size_t> twin_;
};

bool is_straight(const std::vector<Vec3>& run, double tolerance_mm) {
  const Vec3 chord = run.back() - run.front();
  if (!(chord.norm() > tolerance_mm)) return false;
  const Vec3 way = chord.normalized();
  return std::all_of(run.begin(), run.end(),
                     [&](const Vec3& p) { return way.cross(p - run.front()).norm() < tolerance_mm; });
}

// The line that a circle on the face would be centred on: the axis of a surface of revolution; of a sphere
// the one across the plane on the other side.
struct Axis {
  Vec3 point, direction;
};
std::optional<Axis> axis_of(const Face& face, const Face& other) {
  switch (face.type) {
    case SurfaceType::cylinder:
    case SurfaceType::cone:
    case SurfaceType::torus:
      return Axis{face.point_on_axis_mm, face.axis};
    case SurfaceType::sphere:
      if (other.type == SurfaceType::plane) return Axis{face.point_on_axis_mm, other.normal};
      if (other.type == SurfaceType::sphere) {
        const Vec3 between = other.point_on_axis_mm - face.point_on_axis_mm;
        if (between.norm() > kOnCurve_mm) return Axis{face.point_on_axis_mm, between.normalized()};
      }
      return std::nullopt;
    case SurfaceType::plane:
    case SurfaceType::other:
      return std::nullopt;
  }
  return std::nullopt;
}

std::optional<EdgeCircle> circle_about(const Axis& axis, const std::vector<Vec3>& run, double tolerance_mm) {
  double height = 0, radius = 0;
  const auto height_of = [&](const Vec3& p) { return axis.direction.dot(p - axis.point); };
  const auto radius_of = [&](const Vec3& p) { return axis.direction.cross(p - axis.point).norm(); };
  for (const Vec3& p : run) {
    height += height_of(p) / static_cast<double>(run.size());
    radius += radius_of(p) / static_cast<double>(run.size());
  }
  if (!(radius > tolerance_mm)) return std::nullopt;
  for (const Vec3& p : run) {
    if (std::abs(height_of(p) - height) > tolerance_mm || std::abs(radius_of(p) - radius) > tolerance_mm)
      return std::nullopt;
  }
  EdgeCircle circle{axis.point + height * axis.direction, axis.direction, radius};
  const Vec3 start = run[0] - circle.centre_mm, next = run[1] - circle.centre_mm;
  if (circle.axis.dot(start.cross(next)) < 0) circle.axis = -circle.axis;
  return circle;
}

// `run`: the edge's points with both its ends.
LoopEdge edge_of(const Solid& solid, uint32_t face, int beyond, const std::vector<Vec3>& run) {
  LoopEdge edge;
  edge.corner_mm = run.front();
  edge.beyond = beyond;
  const double extent_mm = (solid.box_max_mm - solid.box_min_mm).maxCoeff();
  const double tolerance_mm = std::max(kOnCurve_mm, kOnCurveShare * extent_mm);
  edge.is_line = is_straight(run, tolerance_mm);
  if (edge.is_line) return edge;
  edge.points_mm.assign(run.begin() + 1, run.end() - 1);
  if (beyond == 0) return edge;
  const Face &own = solid.faces()[face], &other = solid.faces()[static_cast<size_t>(beyond) - 1];
  for (const auto& axis : {axis_of(own, other), axis_of(other, own)}) {
    if (axis && !edge.circle) edge.circle = circle_about(*axis, run, tolerance_mm);
  }
  return edge;
}

struct TracedLoop {
  bool is_hole = false;  // in a plane
  uint32_t first_vertex = 0;
  FaceLoop edges;
};

// `loop`: its half-edges in order.
TracedLoop trace(const Solid& solid, const HalfEdges& half_edges, std::vector<size_t> loop) {
  // Begins at the least of its corners, where the face beyond changes; without any at the least vertex.
  size_t start = kNone;
  for (const bool only_corners : {true, false}) {
    for (size_t i = 0; i < loop.size(); ++i) {
      const size_t before = loop[(i + loop.size() - 1) % loop.size()];
      if (only_corners && half_edges.beyond(before) == half_edges.beyond(loop[i])) continue;
      if (start == kNone || half_edges.from(loop[i]) < half_edges.from(loop[start])) start = i;
    }
    if (start != kNone) break;
  }
  std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(start), loop.end());

  TracedLoop traced;
  traced.first_vertex = half_edges.from(loop[0]);
  const uint32_t face = half_edges.face(loop[0]);
  std::vector<Vec3> run{solid.vertices[traced.first_vertex]};
  Vec3 twice_area = Vec3::Zero();
  for (size_t i = 0; i < loop.size(); ++i) {
    const Vec3 &a = solid.vertices[half_edges.from(loop[i])], &b = solid.vertices[half_edges.to(loop[i])];
    twice_area += (a - solid.vertices[traced.first_vertex]).cross(b - a);
    run.push_back(b);
    const bool is_last = i + 1 == loop.size();
    if (!is_last && half_edges.beyond(loop[i]) == half_edges.beyond(loop[i + 1])) continue;
    traced.edges.push_back(edge_of(solid, face, half_edges.beyond(loop[i]), run));
    run = {b};
  }
  traced.is_hole =
      solid.faces()[face].type == SurfaceType::plane && twice_area.dot(solid.faces()[face].normal) < 0;
  return traced;
}

}  // namespace

std::vector<std::vector<FaceLoop>> face_loops(const Solid& solid) {
  const HalfEdges half_edges(solid);
  std::vector<std::vector<TracedLoop>> traced(solid.faces().size());
  std::vector<char> is_done(half_edges.count());
  for (size_t h = 0; h < half_edges.count(); ++h) {
    if (is_done[h] || !half_edges.is_boundary(h)) continue;
    std::vector<size_t> loop;
    for (size_t e = h; !is_done[e]; e = half_edges.following(e)) {
      is_done[e] = 1;
      loop.push_back(e);
    }
    traced[half_edges.face(h)].push_back(trace(solid, half_edges, std::move(loop)));
  }
  std::vector<std::vector<FaceLoop>> result;
  for (std::vector<TracedLoop>& loops : traced) {
    std::stable_sort(loops.begin(), loops.end(), [](const TracedLoop& a, const TracedLoop& b) {
      return std::tuple(a.is_hole, a.first_vertex) < std::tuple(b.is_hole, b.first_vertex);
    });
    std::vector<FaceLoop>& own = result.emplace_back();
    for (TracedLoop& loop : loops) own.push_back(std::move(loop.edges));
  }
  return result;
}

}  // namespace tetragauge
