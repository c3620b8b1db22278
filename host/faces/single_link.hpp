// SPDX-License-Identifier: GPL-3.0-or-later
// Single-link clustering: Sibson, "SLINK: an optimally efficient algorithm for the single-link cluster
// method", The Computer Journal 16 (1973) 30. Time grows with the square of the number of elements, memory
// with the number.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace tetragauge {

// The pointer representation: element i joins the cluster of element joins[i] (> i) at height[i]; the last
// one never does (infinite height).
struct Dendrogram {
  std::vector<double> height;
  std::vector<uint32_t> joins;

  size_t size() const { return height.size(); }
};

// `row(i, d)` fills d[0..i) with the dissimilarities of elements 0..i-1 from element i.
Dendrogram single_link(uint32_t elements, const std::function<void(uint32_t, std::vector<double>&)>& row);

// The cluster of each element when all merges up to `height` are done; clusters count from 0 in the order of
// their first elements.
std::vector<uint32_t> cut_dendrogram(const Dendrogram& dendrogram, double height);

// The merges in ascending order as text, one a line: height, the two clusters, elements in the new one.
// Elements count from 0, the cluster made by merge k is `elements + k` (as SciPy's linkage matrix does).
std::string dendrogram_to_csv(const Dendrogram& dendrogram);

}  // namespace tetragauge
