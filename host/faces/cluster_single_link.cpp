// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "host/faces/cluster_facets.hpp"

namespace tetragauge {
namespace {

// 60,000 triangles are 1.8e9 dissimilarities: about a minute.
constexpr size_t kMostElements = 60000;
constexpr size_t kDoubtful = 6;  // clusters of fewer triangles do not count

// A plane as a point on the hypercylinder: unit sphere times line.
struct HypercylinderPoint {
  Vec3 normal;
  double along;  // distance from the middle over the part's radius
};

double dissimilarity(const HypercylinderPoint& a, const HypercylinderPoint& b) {
  // The angle by its half's sine: exact for small ones, and cheaper than an arc tangent of products.
  const double angle = 2 * std::asin(std::min(1.0, 0.5 * (a.normal - b.normal).norm()));
  return std::hypot(angle, a.along - b.along);
}

std::vector<HypercylinderPoint> on_hypercylinder(const std::vector<FacetElement>& elements) {
  Vec3 low = elements.front().centre, high = low;
  for (const FacetElement& e : elements) {
    low = low.cwiseMin(e.centre);
    high = high.cwiseMax(e.centre);
  }
  const Vec3 middle = 0.5 * (low + high);
  const double radius = std::max(1e-9, 0.5 * (high - low).norm());
  std::vector<HypercylinderPoint> points;
  for (const FacetElement& e : elements)
    points.push_back({e.normal, e.normal.dot(e.centre - middle) / radius});
  return points;
}

// Neighbouring triangles of one face differ by noise alone.
double height_of_noise(const std::vector<FacetElement>& elements,
                       const std::vector<HypercylinderPoint>& points) {
  std::vector<double> steps;
  for (uint32_t i = 0; i < elements.size(); ++i) {
    for (uint32_t j : elements[i].neighbours) {
      if (j < i) steps.push_back(dissimilarity(points[i], points[j]));
    }
  }
  if (steps.empty()) return 0;
  const auto high = steps.begin() + static_cast<long>(steps.size() * 9 / 10);
  std::nth_element(steps.begin(), high, steps.end());
  constexpr double kWorst = 3;  // the largest of some thousand against the tenth percentile from above
  return kWorst * *high;
}

size_t clusters_that_count(const std::vector<uint32_t>& cluster) {
  std::vector<size_t> size;
  for (uint32_t c : cluster) {
    if (c >= size.size()) size.resize(c + 1, 0);
    ++size[c];
  }
  return static_cast<size_t>(
      std::count_if(size.begin(), size.end(), [](size_t n) { return n >= kDoubtful; }));
}

// The widest range of heights with `count` clusters; its middle.
Result<double> height_for_count(const Dendrogram& dendrogram, size_t count) {
  std::vector<double> heights = dendrogram.height;
  std::sort(heights.begin(), heights.end());
  heights.pop_back();  // the last element joins nothing
  double best = -1, width = 0;
  size_t nearest = 0;
  // Only the last merges: below them every triangle stands alone.
  const size_t last = std::min<size_t>(heights.size(), 50 * count + 1000);
  for (size_t k = heights.size() - last; k < heights.size(); ++k) {
    const double next = k + 1 < heights.size() ? heights[k + 1] : 2 * heights[k];
    if (!(next - heights[k] > width)) continue;
    const size_t found = clusters_that_count(cut_dendrogram(dendrogram, heights[k]));
    if (nearest == 0 || std::abs(static_cast<long>(found) - static_cast<long>(count)) <
                            std::abs(static_cast<long>(nearest) - static_cast<long>(count)))
      nearest = found;
    if (found != count) continue;
    width = next - heights[k];
    best = 0.5 * (next + heights[k]);
  }
  if (best < 0)
    return usage_error("faces: no height of the dendrogram gives " + std::to_string(count) +
                       " clusters; the nearest number is " + std::to_string(nearest));
  return best;
}

}  // namespace

Result<FacetClusters> cluster_by_single_link(const std::vector<FacetElement>& elements,
                                             const SingleLinkOptions& options, Dendrogram& dendrogram) {
  FacetClusters result;
  if (elements.empty()) return result;
  if (elements.size() > kMostElements)
    return usage_error("faces: single link compares every triangle with every other; " +
                       std::to_string(elements.size()) + " triangles are more than " +
                       std::to_string(kMostElements) + ": use --cluster grow or normals, or fewer points");
  const std::vector<HypercylinderPoint> points = on_hypercylinder(elements);
  dendrogram = single_link(static_cast<uint32_t>(points.size()), [&](uint32_t i, std::vector<double>& row) {
    for (uint32_t j = 0; j < i; ++j) row[j] = dissimilarity(points[i], points[j]);
  });
  double height = options.height > 0 ? options.height : height_of_noise(elements, points);
  if (options.count > 0) {
    const Result<double> for_count = height_for_count(dendrogram, options.count);
    if (!for_count) return for_count.error();
    height = *for_count;
  }
  result.cluster = cut_dendrogram(dendrogram, height);

  // Those that do not count are doubtful: left to the faces around them.
  std::vector<uint32_t> size, number;
  for (uint32_t c : result.cluster) {
    if (c >= size.size()) size.resize(c + 1, 0);
    ++size[c];
  }
  for (uint32_t n : size) number.push_back(n >= kDoubtful ? result.count++ : kNoCluster);
  for (uint32_t& c : result.cluster) c = number[c];
  return result;
}

}  // namespace tetragauge
