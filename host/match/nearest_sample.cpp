// SPDX-License-Identifier: GPL-3.0-or-later
// Each cell's nearest sample is handed on from cell to cell in sweeps, as Danielsson's distance maps are made
// (Computer Graphics and Image Processing 14 (1980) 227).
#include "host/match/nearest_sample.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
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
  std::vector<float> apart(nearest.size(), std::numeric_limits<float>::max());  // squared, in cells
  std::vector<Eigen::Vector3f> at;  // samples, in cells from the first one's middle
  at.reserve(samples_.size());
  for (const SurfaceSample& sample : samples_)
    at.push_back(((sample.point_mm - low_) / cell_mm_ - Vec3::Constant(0.5)).cast<float>());
  const auto offer = [&](int x, int y, int z, size_t cell, uint16_t sample) {
    if (sample == kNone || sample == nearest[cell]) return;
    const Eigen::Vector3f& s = at[sample];
    const float dx = s.x() - static_cast<float>(x), dy = s.y() - static_cast<float>(y),
                dz = s.z() - static_cast<float>(z);
    const float square = dx * dx + dy * dy + dz * dz;
    if (square >= apart[cell]) return;
    apart[cell] = square;
    nearest[cell] = sample;
  };
  for (size_t i = 0; i < samples_.size(); ++i) {
    if (side && samples_[i].normal.dot(*side) <= 0) continue;
    const auto cell = [&](int k, int n) {
      return std::clamp(static_cast<int>(std::lround(at[i][k])), 0, n - 1);
    };
    const int x = cell(0, nx), y = cell(1, ny), z = cell(2, nz);
    offer(x, y, z, index(x, y, z), static_cast<uint16_t>(i));
  }
  // Plane after plane along z and back; in each, row after row along y and back; in each, along x and back.
  const auto along_x = [&](int y, int z) {
    const size_t row = index(0, y, z);
    for (int x = 1; x < nx; ++x)
      offer(x, y, z, row + static_cast<size_t>(x), nearest[row + static_cast<size_t>(x) - 1]);
    for (int x = nx - 2; x >= 0; --x)
      offer(x, y, z, row + static_cast<size_t>(x), nearest[row + static_cast<size_t>(x) + 1]);
  };
  const auto from = [&](int y, int z, int from_y, int from_z) {
    const size_t row = index(0, y, z), other = index(0, from_y, from_z);
    for (int x = 0; x < nx; ++x)
      offer(x, y, z, row + static_cast<size_t>(x), nearest[other + static_cast<size_t>(x)]);
  };
  for (const int way : {1, -1}) {
    for (int k = 0; k < nz; ++k) {
      const int z = way > 0 ? k : nz - 1 - k;
      if (k > 0)
        for (int y = 0; y < ny; ++y) from(y, z, y, z - way);
      along_x(0, z);
      for (int y = 1; y < ny; ++y) {
        from(y, z, y - 1, z);
        along_x(y, z);
      }
      for (int y = ny - 2; y >= 0; --y) {
        from(y, z, y + 1, z);
        along_x(y, z);
      }
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
