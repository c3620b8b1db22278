// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/surface_graph.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {

namespace {

// Median length of the edges at each vertex; `edges` sorted, both directions.
std::vector<double> typical_edge_mm(const Reconstruction& reconstruction,
                                    const std::vector<std::pair<uint32_t, uint32_t>>& edges) {
  std::vector<double> typical(reconstruction.vertices.size(), 0), lengths;
  for (size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    lengths.clear();
    for (end = begin; end < edges.size() && edges[end].first == edges[begin].first; ++end)
      lengths.push_back(
          (reconstruction.vertices[edges[end].second] - reconstruction.vertices[edges[end].first]).norm());
    const auto middle = lengths.begin() + static_cast<long>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    typical[edges[begin].first] = *middle;
  }
  return typical;
}

}  // namespace

SurfaceGraph surface_graph(const Reconstruction& reconstruction) {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (const SurfaceTriangle& t : reconstruction.surface) {
    if (t.unseen) continue;
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = t.vertex[i], b = t.vertex[(i + 1) % 3];
      edges.emplace_back(a, b);
      edges.emplace_back(b, a);
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

  // An edge much longer than its surroundings spans surface nobody has measured (a gap, the mouth of a slot
  // under a sliver): it connects nothing.
  constexpr double kGap = 3;
  const std::vector<double> typical = typical_edge_mm(reconstruction, edges);
  std::erase_if(edges, [&](const auto& e) {
    const double length = (reconstruction.vertices[e.second] - reconstruction.vertices[e.first]).norm();
    return length >
           kGap * std::max(std::min(typical[e.first], typical[e.second]), reconstruction.vertex_spacing_mm);
  });

  SurfaceGraph graph;
  graph.first.assign(reconstruction.vertices.size() + 1, 0);
  for (const auto& [a, b] : edges) {
    ++graph.first[a + 1];
    graph.neighbour.push_back(b);
  }
  for (size_t v = 0; v + 1 < graph.first.size(); ++v) graph.first[v + 1] += graph.first[v];
  return graph;
}

std::vector<uint32_t> vertices_within(const SurfaceGraph& graph, uint32_t v, int hops, size_t limit) {
  std::vector<uint32_t> found{v};
  size_t ring_begin = 0;
  for (int hop = 0; hop < hops; ++hop) {
    const size_t ring_end = found.size();
    for (size_t i = ring_begin; i < ring_end; ++i) {
      for (uint32_t n : graph.around(found[i])) {
        if (found.size() >= limit) return found;
        if (std::find(found.begin(), found.end(), n) == found.end()) found.push_back(n);
      }
    }
    ring_begin = ring_end;
  }
  return found;
}

double sigma_across(double sigma_along_mm, const Vec3& ray, const Vec3& normal) {
  return sigma_along_mm * std::max(0.05, std::abs(ray.dot(normal)));
}

}  // namespace tetragauge
