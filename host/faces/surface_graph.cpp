// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/surface_graph.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace tetragauge {

SurfaceGraph surface_graph(const Reconstruction& reconstruction) {
  const auto& vertices = reconstruction.vertices;
  // All edges of the seen surface, from both ends, twice where two seen triangles share one.
  std::vector<uint32_t> first(vertices.size() + 1, 0);
  const auto for_each_edge = [&](const auto& put) {
    for (const SurfaceTriangle& t : reconstruction.surface) {
      if (t.unseen) continue;
      for (size_t i = 0; i < 3; ++i) {
        put(t.vertex[i], t.vertex[(i + 1) % 3]);
        put(t.vertex[(i + 1) % 3], t.vertex[i]);
      }
    }
  };
  for_each_edge([&](uint32_t a, uint32_t) { ++first[a + 1]; });
  for (size_t v = 0; v < vertices.size(); ++v) first[v + 1] += first[v];
  std::vector<uint32_t> ends(first.back()), next(first.begin(), first.end() - 1), count(vertices.size());
  for_each_edge([&](uint32_t a, uint32_t b) { ends[next[a]++] = b; });

  // Per vertex ascending, each neighbour once; and the median length of its edges.
  const auto length = [&](uint32_t a, uint32_t b) { return (vertices[b] - vertices[a]).norm(); };
  std::vector<double> typical(vertices.size(), 0);
  const tbb::blocked_range<uint32_t> all(0, static_cast<uint32_t>(vertices.size()), 4096);
  tbb::parallel_for(all, [&](const tbb::blocked_range<uint32_t>& range) {
    std::vector<double> lengths;
    for (uint32_t v = range.begin(); v < range.end(); ++v) {
      const auto begin = ends.begin() + first[v], end = ends.begin() + first[v + 1];
      std::sort(begin, end);
      count[v] = static_cast<uint32_t>(std::unique(begin, end) - begin);
      if (count[v] == 0) continue;
      lengths.clear();
      for (auto n = begin; n != begin + count[v]; ++n) lengths.push_back(length(v, *n));
      const auto middle = lengths.begin() + static_cast<long>(lengths.size() / 2);
      std::nth_element(lengths.begin(), middle, lengths.end());
      typical[v] = *middle;
    }
  });

  // An edge much longer than its surroundings spans surface nobody has measured (a gap, the mouth of a slot
  // under a sliver): it connects nothing.
  constexpr double kGap = 3;
  tbb::parallel_for(all, [&](const tbb::blocked_range<uint32_t>& range) {
    for (uint32_t v = range.begin(); v < range.end(); ++v) {
      const auto begin = ends.begin() + first[v];
      const auto end = std::remove_if(begin, begin + count[v], [&](uint32_t n) {
        return length(v, n) >
               kGap * std::max(std::min(typical[v], typical[n]), reconstruction.vertex_spacing_mm);
      });
      count[v] = static_cast<uint32_t>(end - begin);
    }
  });

  SurfaceGraph graph;
  graph.first.assign(vertices.size() + 1, 0);
  for (size_t v = 0; v < vertices.size(); ++v) graph.first[v + 1] = graph.first[v] + count[v];
  graph.neighbour.reserve(graph.first.back());
  for (size_t v = 0; v < vertices.size(); ++v)
    graph.neighbour.insert(graph.neighbour.end(), ends.begin() + first[v],
                           ends.begin() + first[v] + count[v]);
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
