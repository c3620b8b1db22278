// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/extract_surface.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

constexpr int32_t kNone = -1;

class SurfaceExtractor {
 public:
  SurfaceExtractor(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                   const Visibility& visibility, const Scan& scan, const AveragedPoints& averaged)
      : tetrahedra_(tetrahedra),
        air_(air),
        visibility_(visibility),
        scan_(scan),
        rays_of_(vertex_rays(averaged)) {}

  Surface run() {
    inner_.assign(tetrahedra_.cells.size(), {kNone, kNone, kNone, kNone});
    outer_.assign(tetrahedra_.cells.size(), kNone);
    for (uint32_t c = 0; c < tetrahedra_.cells.size(); ++c) {
      const Cell& cell = tetrahedra_.cells[c];
      for (int i = 0; i < 4; ++i) {
        const uint32_t n = cell.neighbour[static_cast<size_t>(i)];
        // A facet is taken from its solid side; between two infinite cells there is none.
        if (!air_[c] && air_[n] && cell.vertex[static_cast<size_t>(i)] != kInfiniteVertex &&
            !cell.is_infinite())
          add_triangle(c, i, n);
        else if (!air_[c] && cell.is_infinite() && cell.vertex[static_cast<size_t>(i)] == kInfiniteVertex)
          add_sheet(c, i, n);
      }
    }
    for (uint32_t c = 0; c < tetrahedra_.cells.size(); ++c) {
      if (air_[c]) continue;
      for (int i = 0; i < 4; ++i) connect_facet(c, i);
    }
    return {std::move(surface_), std::move(solid_cell_)};
  }

 private:
  // The facet opposite vertex i of finite solid cell c, counter-clockwise from outside it.
  std::array<uint32_t, 3> facet_from_outside(uint32_t c, int i) const {
    const auto& f = kFacet[static_cast<size_t>(i)];
    const auto& v = tetrahedra_.cells[c].vertex;
    return {v[f[0]], v[f[2]], v[f[1]]};
  }

  void add_triangle(uint32_t solid, int i, uint32_t beyond) {
    SurfaceTriangle t;
    t.vertex = facet_from_outside(solid, i);
    t.neighbour = {kNone, kNone, kNone};
    finish(t, beyond, solid);
    inner_[solid][static_cast<size_t>(i)] = static_cast<int32_t>(surface_.size());
    append(t, solid);
  }

  // Infinite cell c claimed solid: its outer side is an unseen triangle; if the finite cell before it is air,
  // its inner side is a seen one.
  void add_sheet(uint32_t c, int i, uint32_t finite) {
    const int j = tetrahedra_.mirror_index(c, i);
    SurfaceTriangle outer;
    outer.vertex = facet_from_outside(finite, j);
    outer.neighbour = {kNone, kNone, kNone};
    outer.unseen = true;
    outer_[c] = static_cast<int32_t>(surface_.size());
    append(outer, c);
    if (!air_[finite]) return;
    SurfaceTriangle inner;
    inner.vertex = {outer.vertex[0], outer.vertex[2], outer.vertex[1]};
    inner.neighbour = {kNone, kNone, kNone};
    finish(inner, finite, c);
    inner_[c][static_cast<size_t>(i)] = static_cast<int32_t>(surface_.size());
    append(inner, c);
  }

  void append(const SurfaceTriangle& t, uint32_t solid) {
    surface_.push_back(t);
    solid_cell_.push_back(solid);
  }

  // Confidence and whether a ray has touched it.
  void finish(SurfaceTriangle& t, uint32_t air_cell, uint32_t solid_cell) const {
    const CellVotes &behind = visibility_.cells[solid_cell], &before = visibility_.cells[air_cell];
    const Votes for_it = behind.solid + before.air, against = behind.air + before.solid;
    t.confidence =
        for_it + against > 0 ? static_cast<float>(for_it) / static_cast<float>(for_it + against) : 0.f;

    // Rays of two of its vertices must come from its outer side, not just along it.
    constexpr double kGrazing = 0.05;  // sine of about 3 degrees
    const Vec3& a = tetrahedra_.vertices[t.vertex[0]];
    const Vec3 normal =
        (tetrahedra_.vertices[t.vertex[1]] - a).cross(tetrahedra_.vertices[t.vertex[2]] - a).normalized();
    int touched = 0;
    for (uint32_t v : t.vertex) {
      for (const uint32_t ray : rays_of_.of(v)) {
        if (normal.dot(scan_.ray_direction(ray)) < -kGrazing) {
          ++touched;
          break;
        }
      }
    }
    t.unseen = touched < 2;
  }

  // Joins the triangle on facet i of solid cell c, and an infinite cell's outer one, to those that bound the
  // same solid across each edge.
  void connect_facet(uint32_t c, int i) {
    const int32_t t = inner_[c][static_cast<size_t>(i)];
    if (t != kNone) {
      SurfaceTriangle& triangle = surface_[static_cast<size_t>(t)];
      for (uint32_t edge = 0; edge < 3; ++edge) {
        const auto [u, w] = edge_of(triangle, edge);
        triangle.neighbour[edge] = turn(c, i, u, w);
      }
    }
    if (tetrahedra_.cells[c].vertex[static_cast<size_t>(i)] == kInfiniteVertex) {
      SurfaceTriangle& outer = surface_[static_cast<size_t>(outer_[c])];
      for (uint32_t edge = 0; edge < 3; ++edge) {
        const auto [u, w] = edge_of(outer, edge);
        outer.neighbour[edge] = turn_outside(c, i, u, w);
      }
    }
  }

  static std::pair<uint32_t, uint32_t> edge_of(const SurfaceTriangle& t, uint32_t edge) {
    return {t.vertex[(edge + 1) % 3], t.vertex[(edge + 2) % 3]};
  }

  // The facet of cell c at edge (u, w) that is not `entered`.
  int other_facet(uint32_t c, int entered, uint32_t u, uint32_t w) const {
    for (int k = 0; k < 4; ++k) {
      const uint32_t v = tetrahedra_.cells[c].vertex[static_cast<size_t>(k)];
      if (k != entered && v != u && v != w) return k;
    }
    return kNone;
  }

  // Turns about edge (u, w) through solid, from cell c whose facet `entered` is behind us, to the triangle
  // that ends the solid.
  int32_t turn(uint32_t c, int entered, uint32_t u, uint32_t w) const {
    for (;;) {
      const int exit = other_facet(c, entered, u, w);
      if (inner_[c][static_cast<size_t>(exit)] != kNone) return inner_[c][static_cast<size_t>(exit)];
      const uint32_t next = tetrahedra_.cells[c].neighbour[static_cast<size_t>(exit)];
      if (air_[next]) return outer_[c];  // only from an infinite cell to the next: the rim of a sheet
      entered = tetrahedra_.mirror_index(c, exit);
      c = next;
    }
  }

  // From the outer side of infinite cell c, whose hull facet is i.
  int32_t turn_outside(uint32_t c, int i, uint32_t u, uint32_t w) const {
    const uint32_t beside = tetrahedra_.cells[c].neighbour[static_cast<size_t>(other_facet(c, i, u, w))];
    if (!air_[beside]) return outer_[beside];
    if (inner_[c][static_cast<size_t>(i)] != kNone) return inner_[c][static_cast<size_t>(i)];
    return turn(tetrahedra_.cells[c].neighbour[static_cast<size_t>(i)], tetrahedra_.mirror_index(c, i), u, w);
  }

  const Tetrahedra& tetrahedra_;
  const std::vector<uint8_t>& air_;
  const Visibility& visibility_;
  const Scan& scan_;
  const VertexRays rays_of_;
  std::vector<std::array<int32_t, 4>> inner_;
  std::vector<int32_t> outer_;
  std::vector<SurfaceTriangle> surface_;
  std::vector<uint32_t> solid_cell_;
};

}  // namespace

Surface extract_surface(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                        const Visibility& visibility, const Scan& scan, const AveragedPoints& averaged) {
  return SurfaceExtractor(tetrahedra, air, visibility, scan, averaged).run();
}

bool is_closed(const std::vector<SurfaceTriangle>& surface) {
  const auto count = static_cast<int32_t>(surface.size());
  for (int32_t t = 0; t < count; ++t) {
    const SurfaceTriangle& triangle = surface[static_cast<size_t>(t)];
    for (size_t i = 0; i < 3; ++i) {
      const int32_t n = triangle.neighbour[i];
      if (n < 0 || n >= count) return false;
      const SurfaceTriangle& other = surface[static_cast<size_t>(n)];
      bool points_back = false;
      for (size_t j = 0; j < 3; ++j) {
        points_back = points_back ||
                      (other.neighbour[j] == t && other.vertex[(j + 1) % 3] == triangle.vertex[(i + 2) % 3] &&
                       other.vertex[(j + 2) % 3] == triangle.vertex[(i + 1) % 3]);
      }
      if (!points_back) return false;
    }
  }
  return true;
}

}  // namespace tetragauge
