// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/face_boundaries.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "host/faces/complete_labels.hpp"

namespace tetragauge {
namespace {

// Each mesh triangle is cut into the pieces that belong to its vertices' faces: vertices are moved onto their
// planes, mesh edges between two faces are cut on the line where the planes meet, triangles between three at
// their corner. The pieces close as the mesh did, and have the faces' true areas and volume.
class MeshCutter {
 public:
  MeshCutter(const Reconstruction& reconstruction, const SurfaceGraph& graph, const FittedFaces& fitted)
      : reconstruction_(reconstruction),
        fits_(fitted.fits),
        label_(complete_labels(reconstruction, graph, fitted)),
        snapped_(reconstruction.vertices),
        area_(fitted.fits.size(), 0.0),
        moment_(fitted.fits.size(), Vec3::Zero()) {
    for (size_t v = 0; v < snapped_.size(); ++v) {
      if (!is_face(label_[v])) continue;
      const PlaneFit& plane = fits_[static_cast<size_t>(label_[v])];
      snapped_[v] -= plane.normal * (plane.normal.dot(snapped_[v]) - plane.d_mm);
    }
  }

  FaceExtents run() {
    FaceExtents result;
    result.faces.resize(fits_.size());
    find_edges();
    for (uint32_t t = 0; t < reconstruction_.surface.size(); ++t) cut(t, result);
    for (size_t f = 0; f < fits_.size(); ++f) {
      FaceExtent& extent = result.faces[f];
      extent.area_mm2 = std::max(0.0, area_[f]);
      extent.centroid_mm = fits_[f].centroid_mm;
      if (area_[f] <= 0) continue;
      extent.centroid_mm += moment_[f] / area_[f];
      // Where no plane gives the edge, the pieces end half way to a vertex that is not on this plane.
      extent.centroid_mm -= fits_[f].normal * (fits_[f].normal.dot(extent.centroid_mm) - fits_[f].d_mm);
    }
    for (size_t f = 0; f < fits_.size(); ++f) {
      for (const auto& [g, line] : edges_[f]) result.faces[f].neighbours.insert(g);
      result.strips += edges_[f].size();
    }
    result.strips /= 2;
    result.volume_mm3 = volume_;
    return result;
  }

 private:
  bool is_face(int32_t label) const { return label >= 0 && label < static_cast<int32_t>(fits_.size()); }

  // The faces that each face meets, and where.
  void find_edges() {
    std::map<std::pair<int32_t, int32_t>, size_t> shared;
    for (const SurfaceTriangle& t : reconstruction_.surface) {
      for (size_t i = 0; i < 3 && !t.unseen; ++i) {
        const int32_t f = label_[t.vertex[i]], g = label_[t.vertex[(i + 1) % 3]];
        if (f != g && is_face(f) && is_face(g)) ++shared[std::minmax(f, g)];
      }
    }
    edges_.resize(fits_.size());
    for (const auto& [pair, count] : shared) {
      if (count < 4) continue;  // an edge of the part has more than one triangle's span; a corner has not
      const auto f = static_cast<size_t>(pair.first), g = static_cast<size_t>(pair.second);
      const auto line = meeting_line(fits_[f], fits_[g]);
      if (!line) continue;
      edges_[f].emplace_back(g, *line);
      edges_[g].emplace_back(f, *line);
    }
  }

  void cut(uint32_t t, FaceExtents& result) {
    const auto& v = reconstruction_.surface[t].vertex;
    const int32_t l[3] = {label_[v[0]], label_[v[1]], label_[v[2]]};
    const bool unseen = reconstruction_.surface[t].unseen;
    double longest = 0;
    for (size_t i = 0; i < 3; ++i)
      longest = std::max(longest, (snapped_[v[(i + 1) % 3]] - snapped_[v[i]]).norm());
    const bool counts = !unseen || is_seen_anyway(v, l, longest);
    if (l[0] == l[1] && l[1] == l[2]) {
      if (is_face(l[0]) && !unseen) result.faces[static_cast<size_t>(l[0])].triangles.push_back(t);
      add_piece(l[0], counts, {snapped_[v[0]], snapped_[v[1]], snapped_[v[2]]});
      return;
    }
    Vec3 between[3];  // on the edge from vertex i to the next
    for (size_t i = 0; i < 3; ++i) {
      const size_t j = (i + 1) % 3;
      between[i] = edge_point(v[i], v[j]);
    }
    for (size_t i = 0; i < 3; ++i) {
      const size_t j = (i + 1) % 3, k = (i + 2) % 3;
      if (l[i] != l[j] || l[k] == l[i]) continue;
      add_piece(l[i], counts, {snapped_[v[i]], snapped_[v[j]], between[j], between[k]});
      add_piece(l[k], counts, {snapped_[v[k]], between[k], between[j]});
      return;
    }
    const Vec3 middle = (between[0] + between[1] + between[2]) / 3;
    const Vec3 corner = corner_near(middle, l, longest).value_or(middle);
    for (size_t i = 0; i < 3; ++i)
      add_piece(l[i], counts, {snapped_[v[i]], between[i], corner, between[(i + 2) % 3]});
  }

  // Where the mesh edge from a to b passes from one face to the next: on the line where their planes meet, if
  // that is anywhere near, else half way.
  Vec3 edge_point(uint32_t a, uint32_t b) const {
    const Vec3 middle = 0.5 * (snapped_[a] + snapped_[b]);
    const int32_t f = label_[a], g = label_[b];
    if (f == g || !is_face(f) || !is_face(g)) return middle;
    // In the same order from both triangles at the edge, so that both get the same point.
    const auto line =
        meeting_line(fits_[static_cast<size_t>(std::min(f, g))], fits_[static_cast<size_t>(std::max(f, g))]);
    if (!line) return middle;
    const Vec3 foot = line->foot(middle);
    return (foot - middle).norm() < reach((snapped_[a] - snapped_[b]).norm()) ? foot : middle;
  }

  // Whether a triangle that no ray has touched by its own normal is surface that was seen all the same.
  // Between points of one face, or all along an edge, it is a sliver turned by their noise; at an edge it is
  // the last stretch up to it. What is wider closes what nobody has seen.
  bool is_seen_anyway(const std::array<uint32_t, 3>& v, const int32_t l[3], double longest_mm) const {
    if (l[0] == l[1] && l[1] == l[2]) return true;
    const double spacing = reconstruction_.vertex_spacing_mm;
    const auto &a = snapped_[v[0]], &b = snapped_[v[1]], &c = snapped_[v[2]];
    if ((b - a).cross(c - a).norm() < spacing * longest_mm) return true;
    const auto near = [&](uint32_t at, const MeetingLine& line, double reach_mm) {
      return (snapped_[at] - line.foot(snapped_[at])).norm() < reach_mm;
    };
    for (const int32_t f : {l[0], l[1], l[2]}) {
      if (!is_face(f)) continue;
      for (const auto& [g, line] : edges_[static_cast<size_t>(f)]) {
        if (near(v[0], line, 2 * spacing) && near(v[1], line, 2 * spacing) && near(v[2], line, 2 * spacing))
          return true;
      }
    }
    for (size_t i = 0; i < 3; ++i) {
      const size_t j = (i + 1) % 3;
      if (l[i] == l[j]) continue;
      if (!is_face(l[i]) || !is_face(l[j])) return false;
      const PlaneFit &f = fits_[static_cast<size_t>(l[i])], &g = fits_[static_cast<size_t>(l[j])];
      const auto line = meeting_line(f, g);
      // Shadows lie in the depth of concave edges; at a convex one two faces that were seen fall away.
      const bool is_convex = f.normal.dot(snapped_[v[j]]) < f.d_mm;
      const double reach = (is_convex ? 8 : 2) * spacing;
      if (!line || !near(v[i], *line, reach) || !near(v[j], *line, reach)) return false;
    }
    return true;
  }

  std::optional<Vec3> corner_near(const Vec3& middle, const int32_t l[3], double longest_mm) const {
    Mat3 normals;
    Vec3 offsets;
    for (int k = 0; k < 3; ++k) {
      if (!is_face(l[k])) return std::nullopt;
      const PlaneFit& plane = fits_[static_cast<size_t>(l[k])];
      normals.row(k) = plane.normal.transpose();
      offsets[k] = plane.d_mm - plane.normal.dot(middle);
    }
    constexpr double kFlat = 0.01;  // spat of the normals: below, two of the planes are as good as parallel
    if (std::abs(normals.determinant()) < kFlat) return std::nullopt;
    const Vec3 step = normals.partialPivLu().solve(offsets);
    if (!(step.norm() < reach(longest_mm))) return std::nullopt;
    return Vec3(middle + step);
  }

  // How far an edge or corner may lie from the mesh that cuts it off: some spacings, or a shadow's width.
  double reach(double mesh_edge_mm) const {
    return 3 * reconstruction_.vertex_spacing_mm + 1.5 * mesh_edge_mm;
  }

  void add_piece(int32_t label, bool counts, std::initializer_list<Vec3> corners) {
    const Vec3* const p = corners.begin();
    const Vec3& origin = reconstruction_.centroid_mm;
    for (size_t k = 1; k + 1 < corners.size(); ++k) {
      volume_ += (p[0] - origin).cross(p[k] - origin).dot(p[k + 1] - origin) / 6;
      if (!counts || !is_face(label)) continue;
      const auto f = static_cast<size_t>(label);
      const double area = 0.5 * (p[k] - p[0]).cross(p[k + 1] - p[0]).dot(fits_[f].normal);
      const Vec3& centroid = fits_[f].centroid_mm;
      area_[f] += area;
      moment_[f] += area / 3 * ((p[0] - centroid) + (p[k] - centroid) + (p[k + 1] - centroid));
    }
  }

  const Reconstruction& reconstruction_;
  const std::vector<PlaneFit>& fits_;
  std::vector<int32_t> label_;
  std::vector<Vec3> snapped_;  // vertices on their faces' planes
  std::vector<double> area_;
  std::vector<Vec3> moment_;                                        // about the fits' centroids
  std::vector<std::vector<std::pair<size_t, MeetingLine>>> edges_;  // per face: another, and where they meet
  double volume_ = 0;
};

// Every corner of it lies on three planes: it is as exact as they are, whatever the mesh makes of a shadow.
bool has_all_corners(const BoundaryLoop& loop) {
  for (size_t i = 0; i < loop.size(); ++i) {
    const BoundaryEdge &edge = loop[i], &next = loop[(i + 1) % loop.size()];
    if (edge.beyond == kNoRegion || edge.beyond == next.beyond) return false;
  }
  return true;
}

double enclosed_area_mm2(const std::vector<BoundaryLoop>& loops, const Vec3& normal) {
  Vec3 enclosed = Vec3::Zero();
  for (const BoundaryLoop& loop : loops) {
    for (size_t i = 0; i < loop.size(); ++i) {
      const Vec3 from = loop[i].from_mm - loop[0].from_mm,
                 to = loop[(i + 1) % loop.size()].from_mm - loop[0].from_mm;
      enclosed += 0.5 * from.cross(to);
    }
  }
  return enclosed.dot(normal);
}

// Faces that meet along an edge of either one's loops: where the strip along the edge happened to stay
// unseen, the loops still tell. Two faces of one plane do not meet, whatever closes the gap between them.
void add_neighbours(const std::vector<PlaneFit>& fits, FaceExtents& extents) {
  for (size_t f = 0; f < extents.faces.size(); ++f) {
    for (const BoundaryLoop& loop : extents.faces[f].loops) {
      for (const BoundaryEdge& edge : loop) {
        const auto beyond = static_cast<size_t>(edge.beyond);
        if (edge.beyond == kNoRegion || !meeting_line(fits[f], fits[beyond])) continue;
        extents.faces[f].neighbours.insert(beyond);
        extents.faces[beyond].neighbours.insert(f);
      }
    }
  }
}

}  // namespace

FaceExtents face_extents(const Reconstruction& reconstruction, const SurfaceGraph& graph,
                         const FittedFaces& fitted) {
  FaceExtents extents = MeshCutter(reconstruction, graph, fitted).run();
  std::vector<std::vector<BoundaryLoop>> loops = trace_boundaries(reconstruction, graph, fitted);
  for (size_t f = 0; f < loops.size(); ++f) {
    FaceExtent& extent = extents.faces[f];
    if (!loops[f].empty() && std::all_of(loops[f].begin(), loops[f].end(), has_all_corners))
      extent.area_mm2 = enclosed_area_mm2(loops[f], fitted.fits[f].normal);
    extent.loops = std::move(loops[f]);
  }
  add_neighbours(fitted.fits, extents);
  return extents;
}

}  // namespace tetragauge
