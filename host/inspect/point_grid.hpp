// SPDX-License-Identifier: GPL-3.0-or-later
// Points in cubes of a given side: "is any of them within a distance (up to the side) of here?"
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/geometry/vec.hpp"

namespace tetragauge {

class PointGrid {
 public:
  // `side_mm` > 0.
  PointGrid(std::span<const Vec3> points_mm, double side_mm);

  // Precondition: distance_mm <= side_mm.
  bool any_within(const Vec3& p, double distance_mm) const;

 private:
  using Cell = std::array<int64_t, 3>;
  struct Entry {
    Cell cell;
    Vec3 point;
  };
  Cell cell_of(const Vec3& p) const;

  double side_mm_;
  std::vector<Entry> entries_;  // by cell
};

}  // namespace tetragauge
