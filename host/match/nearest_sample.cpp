// SPDX-License-Identifier: GPL-3.0-or-later
// Each cell's nearest sample is handed on from cell to cell in two sweeps, as Danielsson's distance maps are
// made (Computer Graphics and Image Processing 14 (1980) 227).
#include "host/match/nearest_sample.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetragauge {
namespace {

constexpr int kCells = 64;        // along the longest side
constexpr double kMargin = 0.15;  // of the longest side, about the samples
constexpr uint16_t kNone = 0xFFFF;

// Along the axes and over the corners of a cube: none is farther than 28 degrees from any direction.
std::vector<Vec3> all_sides() {
  std::vector<Vec3> sides;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const int count = std::abs(x) + std::abs(y) + std::abs(z);
        if (count == 1 || count == 3) sides.push_back(Vec3(x, y, z).normalized());
      }
  return sides;
}

// The index there of the side nearest to a direction: the axis of its largest component, or the corner of its
// octant.
size_t side_towards(const Vec3& direction) {
  // By 9 (x + 1) + 3 (y + 1) + (z + 1).
  constexpr std::array<uint8_t, 27> kIndex{0, 0, 1, 0, 2, 0, 3,  0, 4,  0, 5,  0, 6, 0,
                                           7, 0, 8, 0, 9, 0, 10, 0, 11, 0, 12, 0, 13};
  const Vec3 size = direction.cwiseAbs();
  int axis = 0;
  const double largest = size.maxCoeff(&axis);
  std::array<int, 3> at{1, 1, 1};
  for (int k = 0; k < 3; ++k)
    if (largest * std::numbers::sqrt3 < size.sum() || k == axis)
      at[static_cast<size_t>(k)] = direction[k] < 0 ? 0 : 2;
  return kIndex[static_cast<size_t>(9 * at[0] + 3 * at[1] + at[2])];
}

}  // namespace

NearestSample::NearestSample(std::vector<SurfaceSample> samples, bool by_side)
    : samples_(std::move(samples)) {
  if (by_side) sides_ = all_sides();
  if (samples_.empty()) return;
  Vec3 low = samples_[0].point_mm, high = low;
  for (const SurfaceSample& sample : samples_) {
    low = low.cwiseMin(sample.point_mm);
    high = high.cwiseMax(sample.point_mm);
  }
  const double longest = std::max(1e-9, (high - low).maxCoeff());
  low_ = low - Vec3::Constant(kMargin * longest);
  const Vec3 extent = high - low + Vec3::Constant(2 * kMargin * longest);
  cell_mm_ = extent.maxCoeff() / kCells;
  for (size_t k = 0; k < 3; ++k)
    size_[k] = std::clamp(static_cast<int>(std::ceil(extent[static_cast<int>(k)] / cell_mm_)), 1, kCells);
  nearest_.resize(std::max<size_t>(1, sides_.size()));
  tbb::parallel_for(size_t{0}, nearest_.size(),
                    [&](size_t side) { nearest_[side] = spread(sides_.empty() ? nullptr : &sides_[side]); });
}

std::vector<uint16_t> NearestSample::spread(const Vec3* side) const {
  const auto [nx, ny, nz] = size_;
  std::vector<uint16_t> nearest(static_cast<size_t>(nx * ny * nz), kNone);
  const auto offer = [&](int x, int y, int z, uint16_t sample) {
    uint16_t& at = nearest[index(x, y, z)];
    if (sample == kNone || sample == at) return;
    const Vec3 middle = centre(x, y, z);
    if (at == kNone ||
        (samples_[sample].point_mm - middle).squaredNorm() < (samples_[at].point_mm - middle).squaredNorm())
      at = sample;
  };
  for (size_t i = 0; i < samples_.size(); ++i) {
    if (side && samples_[i].normal.dot(*side) <= 0) continue;
    const Vec3 at = (samples_[i].point_mm - low_) / cell_mm_;
    offer(std::clamp(static_cast<int>(at.x()), 0, nx - 1), std::clamp(static_cast<int>(at.y()), 0, ny - 1),
          std::clamp(static_cast<int>(at.z()), 0, nz - 1), static_cast<uint16_t>(i));
  }
  for (const int way : {1, -1}) {
    const auto first = [&](int n) { return way > 0 ? 0 : n - 1; };
    const auto inside = [](int v, int n) { return v >= 0 && v < n; };
    for (int z = first(nz); inside(z, nz); z += way)
      for (int y = first(ny); inside(y, ny); y += way)
        for (int x = first(nx); inside(x, nx); x += way)
          // The thirteen neighbours that this sweep has passed.
          for (int k = 0; k < 13; ++k) {
            const int a = x + way * (k % 3 - 1), b = y + way * (k / 3 % 3 - 1), c = z + way * (k / 9 - 1);
            if (inside(a, nx) && inside(b, ny) && inside(c, nz)) offer(x, y, z, nearest[index(a, b, c)]);
          }
  }
  return nearest;
}

const SurfaceSample* NearestSample::find(const Vec3& p, const Vec3& towards) const {
  if (samples_.empty()) return nullptr;
  const size_t side = sides_.empty() ? 0 : side_towards(towards);
  const Vec3 at = (p - low_) / cell_mm_;
  const auto cell = [&](int k) {
    return static_cast<int>(std::clamp(at[k], 0.0, size_[static_cast<size_t>(k)] - 1.0));
  };
  const uint16_t found = nearest_[side][index(cell(0), cell(1), cell(2))];
  if (found == kNone) return nullptr;
  const SurfaceSample& sample = samples_[found];
  if (!sides_.empty() && sample.normal.dot(towards) <= 0) return nullptr;
  return &sample;
}

}  // namespace tetragauge
