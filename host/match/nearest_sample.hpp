// SPDX-License-Identifier: GPL-3.0-or-later
// The nearest of many samples in one look-up, to about a cell of a grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/match/surface_samples.hpp"

namespace tetragauge {

class NearestSample {
 public:
  // `by_side`: `find` looks among the samples that face it alone, so that of a thin wall it finds the side
  // that is seen. At most 65,535 samples.
  NearestSample(std::vector<SurfaceSample> samples, bool by_side);

  // Null where none faces `towards` (unit; without sides it does not count). Points outside the grid are
  // taken to the grid's border.
  const SurfaceSample* find(const Vec3& p, const Vec3& towards) const;
  const std::vector<SurfaceSample>& samples() const { return samples_; }

 private:
  std::vector<uint16_t> spread(const Vec3* side) const;
  size_t index(int x, int y, int z) const { return static_cast<size_t>(x + size_[0] * (y + size_[1] * z)); }

  std::vector<SurfaceSample> samples_;
  Vec3 low_ = Vec3::Zero();
  double cell_mm_ = 1;
  std::array<int, 3> size_{1, 1, 1};
  std::vector<Vec3> sides_;
  std::vector<std::vector<uint16_t>> nearest_;  // per side, per cell
};

}  // namespace tetragauge
