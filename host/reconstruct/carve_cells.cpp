// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/carve_cells.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace tetragauge {
namespace {

bool is_long_and_flat(const Tetrahedra& tetrahedra, const Cell& cell, const AveragedPoints& averaged) {
  constexpr double kFlatSigmas = 3, kLongHeights = 10;
  double longest2 = 0, largest_area2 = 0, sigma_mm = 0;  // of squares, and of twice the area
  const auto corner = [&](size_t i) -> const Vec3& { return tetrahedra.vertices[cell.vertex[i]]; };
  for (size_t i = 0; i < 4; ++i) {
    sigma_mm = std::max(sigma_mm, static_cast<double>(averaged.sigma_mm[cell.vertex[i]]));
    for (size_t j = 0; j < i; ++j) longest2 = std::max(longest2, (corner(i) - corner(j)).squaredNorm());
    const auto& f = kFacet[i];
    const Vec3 normal = (corner(f[1]) - corner(f[0])).cross(corner(f[2]) - corner(f[0]));
    largest_area2 = std::max(largest_area2, normal.squaredNorm());
  }
  const double volume6 = (corner(1) - corner(0)).cross(corner(2) - corner(0)).dot(corner(3) - corner(0));
  const double lowest = largest_area2 > 0 ? volume6 / std::sqrt(largest_area2) : 0;  // altitude
  const double longest = std::sqrt(longest2);
  return lowest < kFlatSigmas * sigma_mm && longest > kLongHeights * lowest;
}

// Whether one makes it air depends on air beside it only, so the order does not show.
void peel_long_and_flat(const Tetrahedra& tetrahedra, const AveragedPoints& averaged,
                        std::vector<uint8_t>& air) {
  std::vector<uint32_t> queue;
  for (uint32_t c = 0; c < air.size(); ++c) {
    if (air[c]) queue.push_back(c);
  }
  while (!queue.empty()) {
    const uint32_t c = queue.back();
    queue.pop_back();
    for (const uint32_t n : tetrahedra.cells[c].neighbour) {
      if (air[n] || tetrahedra.cells[n].is_infinite()) continue;
      if (!is_long_and_flat(tetrahedra, tetrahedra.cells[n], averaged)) continue;
      air[n] = 1;
      queue.push_back(n);
    }
  }
}

void shoot_along_axes(const Tetrahedra& tetrahedra, const RayCaster& model, std::vector<uint8_t>& air) {
  Vec3 low = tetrahedra.vertices.front(), high = low;
  for (const Vec3& p : tetrahedra.vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // The model may be larger than what was scanned of it; ten times its extent is outside in any case.
  const double far = 10 * (high - low).norm();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, air.size(), 256),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t c = range.begin(); c < range.end(); ++c) {
                        const Cell& cell = tetrahedra.cells[c];
                        if (air[c] || cell.is_infinite()) continue;
                        Vec3 centroid = Vec3::Zero();
                        for (const uint32_t v : cell.vertex) centroid += 0.25 * tetrahedra.vertices[v];
                        for (int axis = 0; axis < 3 && !air[c]; ++axis) {
                          for (const double side : {-1.0, 1.0}) {
                            if (!model.occluded(centroid + side * far * Vec3::Unit(axis), centroid))
                              air[c] = 1;
                          }
                        }
                      }
                    });
}

}  // namespace

std::vector<uint8_t> carve_cells(const Tetrahedra& tetrahedra, const Visibility& visibility,
                                 const AveragedPoints& averaged, const RayCaster* model) {
  std::vector<uint8_t> air = visibility.crossed;
  for (size_t c = 0; c < air.size(); ++c) {
    if (tetrahedra.cells[c].is_infinite() && visibility.cells[c].into_inside == 0) air[c] = 1;
  }
  peel_long_and_flat(tetrahedra, averaged, air);
  if (model) shoot_along_axes(tetrahedra, *model, air);
  return air;
}

}  // namespace tetragauge
