// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/single_link.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tetragauge {
namespace {

// Merging by brute force: again and again the two nearest clusters.
std::vector<double> merge_heights_by_brute_force(std::vector<std::vector<double>> d) {
  std::vector<double> heights;
  std::vector<size_t> alive(d.size());
  for (size_t i = 0; i < d.size(); ++i) alive[i] = i;
  while (alive.size() > 1) {
    size_t a = 0, b = 1;
    for (size_t i = 0; i < alive.size(); ++i) {
      for (size_t j = 0; j < i; ++j) {
        if (d[alive[i]][alive[j]] < d[alive[a]][alive[b]]) {
          a = i;
          b = j;
        }
      }
    }
    heights.push_back(d[alive[a]][alive[b]]);
    for (size_t k : alive) d[alive[a]][k] = d[k][alive[a]] = std::min(d[alive[a]][k], d[alive[b]][k]);
    alive.erase(alive.begin() + static_cast<long>(b));
  }
  return heights;
}

TEST(SingleLink, HeightsAndClustersOfBruteForce) {
  std::mt19937_64 random(3);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  for (const uint32_t n : {1u, 2u, 7u, 40u}) {
    std::vector<std::pair<double, double>> points;
    for (uint32_t i = 0; i < n; ++i) points.emplace_back(uniform(), uniform());
    const auto distance = [&](uint32_t i, uint32_t j) {
      return std::hypot(points[i].first - points[j].first, points[i].second - points[j].second);
    };
    const Dendrogram dendrogram = single_link(n, [&](uint32_t i, std::vector<double>& row) {
      for (uint32_t j = 0; j < i; ++j) row[j] = distance(i, j);
    });
    std::vector<std::vector<double>> all(n, std::vector<double>(n));
    for (uint32_t i = 0; i < n; ++i) {
      for (uint32_t j = 0; j < n; ++j) all[i][j] = distance(i, j);
    }
    std::vector<double> heights = dendrogram.height;
    std::sort(heights.begin(), heights.end());
    heights.pop_back();
    const std::vector<double> expected = merge_heights_by_brute_force(all);
    ASSERT_EQ(heights.size(), expected.size());
    for (size_t k = 0; k < heights.size(); ++k) EXPECT_EQ(heights[k], expected[k]);

    // Two elements are in one cluster exactly when steps no longer than the height lead from one to the
    // other.
    const double height = 0.15;
    std::vector<std::vector<uint8_t>> reach(n, std::vector<uint8_t>(n));
    for (uint32_t i = 0; i < n; ++i) {
      for (uint32_t j = 0; j < n; ++j) reach[i][j] = distance(i, j) <= height;
    }
    for (uint32_t k = 0; k < n; ++k) {
      for (uint32_t i = 0; i < n; ++i) {
        for (uint32_t j = 0; j < n; ++j) reach[i][j] = reach[i][j] || (reach[i][k] && reach[k][j]);
      }
    }
    const std::vector<uint32_t> cluster = cut_dendrogram(dendrogram, height);
    for (uint32_t i = 0; i < n; ++i) {
      for (uint32_t j = 0; j < n; ++j) EXPECT_EQ(cluster[i] == cluster[j], reach[i][j] != 0);
    }
  }
}

TEST(SingleLink, MergesAsText) {
  const double x[] = {0, 1, 10, 12};
  const Dendrogram dendrogram = single_link(4, [&](uint32_t i, std::vector<double>& row) {
    for (uint32_t j = 0; j < i; ++j) row[j] = std::abs(x[i] - x[j]);
  });
  EXPECT_EQ(dendrogram_to_csv(dendrogram),
            "height,cluster_a,cluster_b,elements\n1,0,1,2\n2,2,3,2\n9,4,5,4\n");
}

}  // namespace
}  // namespace tetragauge
