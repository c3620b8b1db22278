// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/face_boundaries.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace tetragauge {
namespace {

struct Line {
  Vec3 point, direction;
  Vec3 foot(const Vec3& p) const { return point + direction * direction.dot(p - point); }
};

// Where two planes meet; none for planes within about 3 degrees of one another.
std::optional<Line> meeting_line(const PlaneFit& f, const PlaneFit& g) {
  const Vec3 direction = f.normal.cross(g.normal);
  const double sine2 = direction.squaredNorm();
  if (sine2 < 0.0025) return std::nullopt;
  const Vec3 point = (f.d_mm * g.normal.cross(direction) + g.d_mm * direction.cross(f.normal)) / sine2;
  return Line{point, direction / std::sqrt(sine2)};
}

// Sums signed areas and first moments of polygons in one plane.
class AreaSum {
 public:
  explicit AreaSum(const PlaneFit& plane) : plane_(plane) {}

  void add_triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 pa = on_plane(a), pb = on_plane(b), pc = on_plane(c);
    const double area = 0.5 * (pb - pa).cross(pc - pa).dot(plane_.normal);
    area_ += area;
    moment_ += area / 3 * (pa + pb + pc);
  }
  double area() const { return area_; }
  Vec3 centroid() const {
    return area_ > 0 ? Vec3(plane_.centroid_mm + moment_ / area_) : plane_.centroid_mm;
  }

 private:
  Vec3 on_plane(const Vec3& p) const {
    const Vec3 r = p - plane_.centroid_mm;
    return r - plane_.normal * plane_.normal.dot(r);
  }

  const PlaneFit& plane_;
  double area_ = 0;
  Vec3 moment_ = Vec3::Zero();
};

class ExtentFinder {
 public:
  ExtentFinder(const Reconstruction& reconstruction, const SurfaceGraph& graph, const FittedFaces& fitted)
      : reconstruction_(reconstruction), graph_(graph), fitted_(fitted), label_(fitted.vertex_face) {}

  FaceExtents run() {
    fill_labels();
    FaceExtents result;
    result.faces.resize(fitted_.fits.size());
    std::vector<AreaSum> sums;
    for (const PlaneFit& fit : fitted_.fits) sums.emplace_back(fit);
    std::map<std::pair<int32_t, int32_t>, size_t> shared;
    for (uint32_t t = 0; t < reconstruction_.surface.size(); ++t) {
      const SurfaceTriangle& triangle = reconstruction_.surface[t];
      if (triangle.unseen) continue;
      const int32_t l[3] = {label(triangle, 0), label(triangle, 1), label(triangle, 2)};
      if (l[0] == l[1] && l[1] == l[2]) {
        if (l[0] == kNoRegion) continue;
        const auto f = static_cast<size_t>(l[0]);
        sums[f].add_triangle(at(triangle, 0), at(triangle, 1), at(triangle, 2));
        result.faces[f].triangles.push_back(t);
        continue;
      }
      for (size_t i = 0; i < 3; ++i) {
        const size_t j = (i + 1) % 3, k = (i + 2) % 3;
        if (l[i] != kNoRegion && l[j] != kNoRegion && l[i] != l[j]) ++shared[std::minmax(l[i], l[j])];
        if (l[i] != kNoRegion && l[i] == l[j] && l[k] != kNoRegion)
          extend(sums[static_cast<size_t>(l[i])], l[i], l[k], at(triangle, i), at(triangle, j));
      }
    }
    for (size_t f = 0; f < sums.size(); ++f) {
      result.faces[f].area_mm2 = std::max(0.0, sums[f].area());
      result.faces[f].centroid_mm = sums[f].centroid();
    }
    for (const auto& [pair, count] : shared) {
      if (count < 4) continue;  // an edge of the part has more than one triangle's span; a corner has not
      const auto f = static_cast<size_t>(pair.first), g = static_cast<size_t>(pair.second);
      if (!meeting_line(fitted_.fits[f], fitted_.fits[g])) continue;
      result.faces[f].neighbours.insert(g);
      result.faces[g].neighbours.insert(f);
      ++result.strips;
    }
    return result;
  }

 private:
  int32_t label(const SurfaceTriangle& t, size_t i) const { return label_[t.vertex[i]]; }
  const Vec3& at(const SurfaceTriangle& t, size_t i) const { return reconstruction_.vertices[t.vertex[i]]; }

  // A vertex on no face (mixed, outlier) counts, for extent only, to the face most of its neighbours are on.
  void fill_labels() {
    for (int round = 0; round < 2; ++round) {
      std::vector<int32_t> filled = label_;
      for (uint32_t v = 0; v < graph_.size(); ++v) {
        if (label_[v] != kNoRegion) continue;
        std::map<int32_t, int> votes;
        for (uint32_t n : graph_.around(v)) {
          if (label_[n] != kNoRegion) ++votes[label_[n]];
        }
        int best = 1;  // one neighbour alone does not draw a vertex in
        for (const auto& [f, count] : votes) {
          if (count > best) {
            best = count;
            filled[v] = f;
          }
        }
      }
      label_ = std::move(filled);
    }
  }

  // The piece of face f between its outermost mesh edge a b and the line where it meets g.
  void extend(AreaSum& sum, int32_t f, int32_t g, const Vec3& a, const Vec3& b) const {
    const auto line =
        meeting_line(fitted_.fits[static_cast<size_t>(f)], fitted_.fits[static_cast<size_t>(g)]);
    if (!line) return;
    const Vec3 foot_a = line->foot(a), foot_b = line->foot(b);
    const double reach = 3 * reconstruction_.vertex_spacing_mm;  // farther off, the planes do not meet here
    if ((foot_a - a).norm() > reach || (foot_b - b).norm() > reach) return;
    sum.add_triangle(a, b, foot_b);
    sum.add_triangle(a, foot_b, foot_a);
  }

  const Reconstruction& reconstruction_;
  const SurfaceGraph& graph_;
  const FittedFaces& fitted_;
  std::vector<int32_t> label_;
};

}  // namespace

FaceExtents face_extents(const Reconstruction& reconstruction, const SurfaceGraph& graph,
                         const FittedFaces& fitted) {
  return ExtentFinder(reconstruction, graph, fitted).run();
}

}  // namespace tetragauge
