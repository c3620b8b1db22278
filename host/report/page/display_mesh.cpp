// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/display_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

namespace tetragauge {
namespace {

constexpr size_t kMostVertices = 65536;  // indices of 16 bits
constexpr double kGrowth = 1.25;         // of grid or edge from one try to the next

// Vertices are numbered by face, so that neighbours can be coloured apart.
struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<uint32_t> vertex_face;
  std::vector<std::array<uint32_t, 3>> triangles;
};

// `stands_for`: of each vertex of the model the one that is drawn in its place.
Mesh split_by_face(const Solid& model, const std::vector<uint32_t>& stands_for) {
  Mesh mesh;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> known;  // face, vertex
  for (size_t k = 0; k < model.triangles.size(); ++k) {
    const uint32_t face = model.triangle_face[k];
    std::array<uint32_t, 3> t{};
    for (size_t i = 0; i < 3; ++i) t[i] = stands_for[model.triangles[k][i]];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (uint32_t& corner : t) {
      const uint32_t next = static_cast<uint32_t>(mesh.vertices.size());
      const auto [entry, is_new] = known.try_emplace({face, corner}, next);
      if (is_new) {
        mesh.vertices.push_back(model.vertices[corner]);
        mesh.vertex_face.push_back(face);
      }
      corner = entry->second;
    }
    mesh.triangles.push_back(t);
  }
  return mesh;
}

std::vector<uint32_t> faces_at_vertex(const Solid& model) {
  std::set<std::pair<uint32_t, uint32_t>> seen;
  std::vector<uint32_t> count(model.vertices.size(), 0);
  for (size_t k = 0; k < model.triangles.size(); ++k)
    for (const uint32_t vertex : model.triangles[k])
      count[vertex] += seen.emplace(vertex, model.triangle_face[k]).second;
  return count;
}

// All vertices within one cube of a grid become one of them (Rossignac and Borrel, Modeling in Computer
// Graphics (1993) 455): the one where most faces meet, so that corners and edges stay.
std::vector<uint32_t> snapped(const Solid& model, const std::vector<uint32_t>& faces_at, double cell_mm) {
  std::map<std::tuple<int64_t, int64_t, int64_t>, uint32_t> of_cell;
  const auto cell = [&](uint32_t vertex) {
    const auto along = [&](int axis) {
      return std::llround(std::floor(model.vertices[vertex][axis] / cell_mm));
    };
    return std::tuple(along(0), along(1), along(2));
  };
  for (uint32_t k = 0; k < model.vertices.size(); ++k) {
    uint32_t& best = of_cell.try_emplace(cell(k), k).first->second;
    if (faces_at[k] > faces_at[best]) best = k;
  }
  std::vector<uint32_t> stands_for(model.vertices.size());
  for (uint32_t k = 0; k < stands_for.size(); ++k) stands_for[k] = of_cell.at(cell(k));
  return stands_for;
}

// One round: every edge longer than `edge_mm` gets a vertex in its middle. Whether it does is the edge's own
// affair, so both its triangles agree.
bool halve_edges(Mesh& mesh, double edge_mm) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  const auto middle = [&](uint32_t a, uint32_t b) -> int64_t {
    if ((mesh.vertices[a] - mesh.vertices[b]).norm() <= edge_mm) return -1;
    const auto [entry, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(mesh.vertices.size()));
    if (is_new) {
      mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
      mesh.vertex_face.push_back(mesh.vertex_face[a]);
    }
    return entry->second;
  };
  std::vector<std::array<uint32_t, 3>> out;
  for (const auto& t : mesh.triangles) {
    std::array<int64_t, 3> m{};
    for (size_t i = 0; i < 3; ++i) m[i] = middle(t[i], t[(i + 1) % 3]);
    const auto count = std::count_if(m.begin(), m.end(), [](int64_t x) { return x >= 0; });
    const auto at = [&](size_t i) { return static_cast<uint32_t>(m[i % 3]); };
    if (count == 0) {
      out.push_back(t);
    } else if (count == 3) {
      out.insert(out.end(),
                 {{t[0], at(0), at(2)}, {t[1], at(1), at(0)}, {t[2], at(2), at(1)}, {at(0), at(1), at(2)}});
    } else {
      // Turned so that the first edge is halved and, of two, the second one too.
      size_t i = 0;
      while (m[i] < 0 || (count == 2 && m[(i + 1) % 3] < 0)) ++i;
      const uint32_t a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
      if (count == 1) {
        out.insert(out.end(), {{a, at(i), c}, {at(i), b, c}});
      } else {
        out.insert(out.end(), {{at(i), b, at(i + 1)}, {a, at(i), at(i + 1)}, {a, at(i + 1), c}});
      }
    }
  }
  mesh.triangles = std::move(out);
  return !middles.empty();
}

bool fits(const Mesh& mesh, size_t most_triangles) {
  return mesh.triangles.size() <= most_triangles && mesh.vertices.size() <= kMostVertices;
}

}  // namespace

DisplayMesh display_mesh(const Solid& model, size_t most_triangles) {
  std::vector<uint32_t> itself(model.vertices.size());
  std::iota(itself.begin(), itself.end(), 0u);
  Mesh mesh = split_by_face(model, itself);
  DisplayMesh out;
  const double size_mm = (model.box_max_mm - model.box_min_mm).norm();
  const double area_mm2 = std::max(model.area_mm2, 1e-6 * size_mm * size_mm);
  if (!fits(mesh, most_triangles)) {
    out.is_coarser = true;
    const std::vector<uint32_t> faces_at = faces_at_vertex(model);
    double cell_mm = std::sqrt(area_mm2 / static_cast<double>(most_triangles));
    for (; !fits(mesh, most_triangles); cell_mm *= kGrowth)
      mesh = split_by_face(model, snapped(model, faces_at, cell_mm));
  } else if (!mesh.triangles.empty()) {
    // Halving leaves edges of about 0.7 of the longest allowed: two triangles to half its square.
    double edge_mm = std::sqrt(4 * area_mm2 / static_cast<double>(most_triangles));
    for (bool done = false; !done; edge_mm *= kGrowth) {
      Mesh fine = mesh;
      while (fits(fine, most_triangles) && halve_edges(fine, edge_mm)) {
      }
      done = fits(fine, most_triangles);
      if (done) mesh = std::move(fine);
    }
  }
  out.vertices = std::move(mesh.vertices);
  out.vertex_face = std::move(mesh.vertex_face);
  for (const auto& [a, b, c] : mesh.triangles)
    out.triangles.push_back({static_cast<uint16_t>(a), static_cast<uint16_t>(b), static_cast<uint16_t>(c)});
  return out;
}

}  // namespace tetragauge
