// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/single_link.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <numeric>

namespace tetragauge {
namespace {

// Elements in the order in which they join.
std::vector<uint32_t> merge_order(const Dendrogram& dendrogram) {
  std::vector<uint32_t> order(dendrogram.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return dendrogram.height[a] < dendrogram.height[b]; });
  if (!order.empty()) order.pop_back();  // the last element joins nothing
  return order;
}

uint32_t root_of(std::vector<uint32_t>& parent, uint32_t i) {
  while (parent[i] != i) {
    parent[i] = parent[parent[i]];
    i = parent[i];
  }
  return i;
}

}  // namespace

Dendrogram single_link(uint32_t elements, const std::function<void(uint32_t, std::vector<double>&)>& row) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  Dendrogram d;
  d.height.assign(elements, kNever);
  d.joins.resize(elements);
  std::vector<double> m(elements);
  for (uint32_t i = 0; i < elements; ++i) {  // steps 1 to 4 of Sibson's algorithm, section 4
    d.joins[i] = i;
    row(i, m);
    for (uint32_t j = 0; j < i; ++j) {
      const uint32_t to = d.joins[j];
      if (d.height[j] >= m[j]) {
        m[to] = std::min(m[to], d.height[j]);
        d.height[j] = m[j];
        d.joins[j] = i;
      } else {
        m[to] = std::min(m[to], m[j]);
      }
    }
    for (uint32_t j = 0; j < i; ++j) {
      if (d.height[j] >= d.height[d.joins[j]]) d.joins[j] = i;
    }
  }
  return d;
}

std::vector<uint32_t> cut_dendrogram(const Dendrogram& dendrogram, double height) {
  const auto n = static_cast<uint32_t>(dendrogram.size());
  std::vector<uint32_t> parent(n);
  std::iota(parent.begin(), parent.end(), 0u);
  for (uint32_t i = 0; i < n; ++i) {
    if (dendrogram.height[i] <= height) parent[root_of(parent, i)] = root_of(parent, dendrogram.joins[i]);
  }
  std::vector<uint32_t> number(n, UINT32_MAX), cluster(n);
  uint32_t next = 0;
  for (uint32_t i = 0; i < n; ++i) {
    uint32_t& of_root = number[root_of(parent, i)];
    if (of_root == UINT32_MAX) of_root = next++;
    cluster[i] = of_root;
  }
  return cluster;
}

std::string dendrogram_to_csv(const Dendrogram& dendrogram) {
  const auto n = static_cast<uint32_t>(dendrogram.size());
  std::vector<uint32_t> parent(n), made(n), count(n, 1);
  std::iota(parent.begin(), parent.end(), 0u);
  std::iota(made.begin(), made.end(), 0u);
  std::string text = "height,cluster_a,cluster_b,elements\n";
  uint32_t next = n;
  for (const uint32_t i : merge_order(dendrogram)) {
    const uint32_t a = root_of(parent, i), b = root_of(parent, dendrogram.joins[i]);
    const uint32_t low = std::min(made[a], made[b]), high = std::max(made[a], made[b]);
    parent[a] = b;
    count[b] += count[a];
    made[b] = next++;
    char line[120];
    std::snprintf(line, sizeof line, "%.9g,%u,%u,%u\n", dendrogram.height[i], low, high, count[b]);
    text += line;
  }
  return text;
}

}  // namespace tetragauge
