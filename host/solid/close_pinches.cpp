// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/close_pinches.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace tetragauge {
namespace {

using Edge = std::pair<uint32_t, uint32_t>;

// How much more often each edge is run from its lesser vertex than to it; a triangle that has shrunk to a
// line runs its edges both ways.
std::map<Edge, int> balance_of(const std::vector<std::array<uint32_t, 3>>& triangles,
                               const std::vector<uint32_t>* vertex) {
  std::map<Edge, int> balance;
  for (const auto& t : triangles) {
    for (size_t k = 0; k < 3; ++k) {
      uint32_t a = t[k], b = t[(k + 1) % 3];
      if (vertex) {
        a = (*vertex)[a];
        b = (*vertex)[b];
      }
      if (a != b) balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  return balance;
}

bool is_even(const std::map<Edge, int>& balance) {
  return std::all_of(balance.begin(), balance.end(), [](const auto& edge) { return edge.second == 0; });
}

uint32_t root(std::vector<uint32_t>& parent, uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Each of `open` with all vertices nearer than `reach_mm`, and those with one another; the least stands for
// all.
std::vector<uint32_t> drawn_together(const std::vector<Vec3>& vertices, const std::vector<uint32_t>& open,
                                     double reach_mm) {
  std::vector<uint32_t> parent(vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  for (const uint32_t v : open) {
    const Vec3& p = vertices[v];
    const auto first = std::lower_bound(vertices.begin(), vertices.end(), p.x() - reach_mm,
                                        [](const Vec3& q, double x) { return q.x() < x; });
    for (auto q = first; q != vertices.end() && q->x() <= p.x() + reach_mm; ++q) {
      if ((*q - p).norm() > reach_mm) continue;
      const uint32_t a = root(parent, v), b = root(parent, static_cast<uint32_t>(q - vertices.begin()));
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (uint32_t i = 0; i < parent.size(); ++i) parent[i] = root(parent, i);
  return parent;
}

}  // namespace

bool is_closed(const std::vector<std::array<uint32_t, 3>>& triangles) {
  return is_even(balance_of(triangles, nullptr));
}

std::vector<uint32_t> close_pinches(const std::vector<Vec3>& vertices,
                                    const std::vector<std::array<uint32_t, 3>>& triangles, double reach_mm) {
  std::vector<uint32_t> open;
  for (const auto& [edge, count] : balance_of(triangles, nullptr)) {
    if (count != 0) open.insert(open.end(), {edge.first, edge.second});
  }
  std::sort(open.begin(), open.end());
  open.erase(std::unique(open.begin(), open.end()), open.end());
  // From a nanometre up, each time ten times as far.
  for (double reach = 1e-6; !open.empty() && reach < 10 * reach_mm; reach *= 10) {
    const std::vector<uint32_t> vertex = drawn_together(vertices, open, std::min(reach, reach_mm));
    if (is_even(balance_of(triangles, &vertex))) return vertex;
  }
  return {};
}

}  // namespace tetragauge
