// SPDX-License-Identifier: GPL-3.0-or-later
// The seen surface as a graph of its vertices: neighbours along the edges of seen triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/reconstruct/reconstruct.hpp"

namespace tetragauge {

struct SurfaceGraph {
  std::vector<uint32_t> first;      // per vertex, into neighbour; one more at the end
  std::vector<uint32_t> neighbour;  // ascending per vertex

  size_t size() const { return first.size() - 1; }
  std::span<const uint32_t> around(uint32_t v) const {
    return {neighbour.data() + first[v], neighbour.data() + first[v + 1]};
  }
};

SurfaceGraph surface_graph(const Reconstruction& reconstruction);

// Vertices within `hops` edges of v, v first, then by distance, at most `limit`.
std::vector<uint32_t> vertices_within(const SurfaceGraph& graph, uint32_t v, int hops, size_t limit);

// One standard deviation of a point across a plane. Light that grazes the plane says less than the cosine
// promises (spot size, pointing), so the cosine is held above a twentieth.
double sigma_across(double sigma_along_mm, const Vec3& ray, const Vec3& normal);

}  // namespace tetragauge
