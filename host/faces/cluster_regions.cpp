// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "host/faces/cluster_facets.hpp"
#include "host/geometry/fit_plane.hpp"

namespace tetragauge {
namespace {

// Connected pieces of the clusters; per element its piece.
std::vector<uint32_t> connected_pieces(const std::vector<FacetElement>& elements,
                                       const FacetClusters& clusters, uint32_t& count) {
  std::vector<uint32_t> piece(elements.size(), kNoCluster), queue;
  count = 0;
  for (uint32_t seed = 0; seed < elements.size(); ++seed) {
    if (piece[seed] != kNoCluster || clusters.cluster[seed] == kNoCluster) continue;
    queue.assign(1, seed);
    piece[seed] = count;
    for (size_t at = 0; at < queue.size(); ++at) {
      for (uint32_t n : elements[queue[at]].neighbours) {
        if (piece[n] != kNoCluster || clusters.cluster[n] != clusters.cluster[seed]) continue;
        piece[n] = count;
        queue.push_back(n);
      }
    }
    ++count;
  }
  return piece;
}

}  // namespace

Regions regions_of_clusters(const Reconstruction& reconstruction, const std::vector<FacetElement>& elements,
                            const FacetClusters& clusters) {
  uint32_t pieces = 0;
  const std::vector<uint32_t> piece = connected_pieces(elements, clusters, pieces);
  std::vector<std::vector<uint32_t>> vertices(pieces);
  for (size_t k = 0; k < elements.size(); ++k) {
    if (piece[k] == kNoCluster) continue;
    for (uint32_t v : reconstruction.surface[elements[k].triangle].vertex) vertices[piece[k]].push_back(v);
  }
  // Large pieces first: a vertex between two goes to the larger.
  std::vector<uint32_t> order(pieces);
  for (uint32_t p = 0; p < pieces; ++p) {
    order[p] = p;
    std::sort(vertices[p].begin(), vertices[p].end());
    vertices[p].erase(std::unique(vertices[p].begin(), vertices[p].end()), vertices[p].end());
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return vertices[a].size() > vertices[b].size(); });

  Regions regions;
  regions.vertex_region.assign(reconstruction.vertices.size(), kNoRegion);
  for (uint32_t p : order) {
    constexpr size_t kFewest = 6;  // 3 parameters, and as many degrees of freedom to test them
    if (vertices[p].size() < kFewest) break;
    std::vector<Vec3> points;
    Vec3 towards = Vec3::Zero();
    for (uint32_t v : vertices[p]) {
      points.push_back(reconstruction.vertices[v]);
      towards -= reconstruction.vertex_ray[v];
    }
    const auto plane = fit_plane(points, {}, towards);
    if (!plane) continue;
    const auto region = static_cast<int32_t>(regions.planes.size());
    regions.planes.push_back({plane->normal, plane->d_mm});
    for (uint32_t v : vertices[p]) {
      if (regions.vertex_region[v] == kNoRegion) regions.vertex_region[v] = region;
    }
  }
  return regions;
}

}  // namespace tetragauge
