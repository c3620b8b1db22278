// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/faces/cluster_facets.hpp"

namespace tetragauge {
namespace {

constexpr double kGate = 4;             // standard deviations of a corrected normal
constexpr double kLeastAngle = 0.0087;  // rad: half a degree, by which a face may bow
constexpr double kGap = 6;              // standard deviations of a triangle's height between parallel faces
constexpr size_t kDoubtful = 4;         // fewer triangles are no level of their own

double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Parallel faces of one direction: the mid-planes between them, ascending along the normal.
std::vector<double> mid_planes(std::vector<double> offsets, double height_sigma_mm) {
  std::sort(offsets.begin(), offsets.end());
  std::vector<double> levels;  // means of groups between gaps
  for (size_t begin = 0, end = 0; begin < offsets.size(); begin = end) {
    double sum = 0;
    for (end = begin;
         end < offsets.size() && (end == begin || offsets[end] - offsets[end - 1] <= kGap * height_sigma_mm);
         ++end)
      sum += offsets[end];
    if (end - begin >= kDoubtful) levels.push_back(sum / static_cast<double>(end - begin));
  }
  std::vector<double> planes;
  for (size_t k = 1; k < levels.size(); ++k) planes.push_back(0.5 * (levels[k - 1] + levels[k]));
  return planes;
}

// A cluster as one plane.
struct Mean {
  Vec3 normal = Vec3::Zero(), centre = Vec3::Zero();
  double area_mm2 = 0;
};

// Doubtful clusters, whose normals noise has led astray, lie on a larger one's plane and go to it.
void merge_doubtful(const std::vector<FacetElement>& elements, double height_sigma_mm,
                    FacetClusters& clusters) {
  std::vector<Mean> means(clusters.count);
  for (size_t k = 0; k < elements.size(); ++k) {
    if (clusters.cluster[k] == kNoCluster) continue;
    Mean& mean = means[clusters.cluster[k]];
    mean.normal += elements[k].area_mm2 * elements[k].normal;
    mean.centre += elements[k].area_mm2 * elements[k].centre;
    mean.area_mm2 += elements[k].area_mm2;
  }
  std::vector<uint32_t> order(means.size()), becomes(means.size());
  for (uint32_t c = 0; c < means.size(); ++c) {
    order[c] = becomes[c] = c;
    means[c].normal.normalize();
    means[c].centre /= means[c].area_mm2;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return means[a].area_mm2 > means[b].area_mm2; });
  constexpr double kSmall = 0.1, kFacing = 0.8;  // share of the larger one's area; product of the normals
  for (size_t s = 1; s < order.size(); ++s) {
    const Mean& small = means[order[s]];
    for (size_t l = 0; l < s; ++l) {
      const Mean& large = means[order[l]];
      if (becomes[order[l]] != order[l] || small.area_mm2 > kSmall * large.area_mm2) continue;
      if (small.normal.dot(large.normal) < kFacing ||
          std::abs(large.normal.dot(small.centre - large.centre)) > kGap * height_sigma_mm)
        continue;
      becomes[order[s]] = order[l];
      break;
    }
  }
  std::vector<uint32_t> number(means.size(), kNoCluster);
  clusters.count = 0;
  for (uint32_t c = 0; c < means.size(); ++c) {
    if (becomes[c] == c) number[c] = clusters.count++;
  }
  for (uint32_t& c : clusters.cluster) {
    if (c != kNoCluster) c = number[becomes[c]];
  }
}

}  // namespace

FacetClusters cluster_by_normals(const std::vector<FacetElement>& elements) {
  FacetClusters result;
  result.cluster.assign(elements.size(), kNoCluster);
  if (elements.empty()) return result;
  std::vector<double> normal_sigmas, height_sigmas;
  for (const FacetElement& e : elements) {
    normal_sigmas.push_back(e.normal_sigma);
    height_sigmas.push_back(e.height_sigma_mm);
  }
  const double least_product = std::cos(std::max(kLeastAngle, kGate * middle_of(normal_sigmas)));
  const double height_sigma = middle_of(height_sigmas);

  std::vector<uint32_t> order(elements.size());  // the surest normals lead
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return elements[a].normal_sigma < elements[b].normal_sigma;
  });
  std::vector<uint32_t> members;
  for (const uint32_t leader : order) {
    if (result.cluster[leader] != kNoCluster) continue;
    Vec3 direction = elements[leader].normal;
    constexpr int kTurns = 5;
    for (int turn = 0; turn < kTurns; ++turn) {
      members.clear();
      Vec3 sum = Vec3::Zero();
      for (uint32_t k = 0; k < elements.size(); ++k) {
        if (result.cluster[k] != kNoCluster || elements[k].normal.dot(direction) < least_product) continue;
        members.push_back(k);
        sum += elements[k].area_mm2 * elements[k].normal;
      }
      if (members.size() < kDoubtful) break;
      direction = sum.normalized();
    }
    if (members.size() < kDoubtful) continue;  // doubtful: left to the faces around it
    std::vector<double> offsets;
    for (uint32_t k : members) offsets.push_back(direction.dot(elements[k].centre));
    const std::vector<double> planes = mid_planes(offsets, height_sigma);
    for (size_t m = 0; m < members.size(); ++m) {
      const auto level = std::upper_bound(planes.begin(), planes.end(), offsets[m]) - planes.begin();
      result.cluster[members[m]] = result.count + static_cast<uint32_t>(level);
    }
    result.count += static_cast<uint32_t>(planes.size()) + 1;
  }
  merge_doubtful(elements, height_sigma, result);
  return result;
}

}  // namespace tetragauge
