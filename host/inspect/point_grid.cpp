// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/point_grid.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {

PointGrid::PointGrid(std::span<const Vec3> points_mm, double side_mm) : side_mm_(side_mm) {
  entries_.reserve(points_mm.size());
  for (const Vec3& p : points_mm) entries_.push_back({cell_of(p), p});
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.cell < b.cell; });
}

PointGrid::Cell PointGrid::cell_of(const Vec3& p) const {
  Cell cell{};
  for (size_t k = 0; k < 3; ++k)
    cell[k] = static_cast<int64_t>(std::floor(p[static_cast<Eigen::Index>(k)] / side_mm_));
  return cell;
}

bool PointGrid::any_within(const Vec3& p, double distance_mm) const {
  const Cell centre = cell_of(p);
  const double limit = distance_mm * distance_mm;
  for (int64_t x = centre[0] - 1; x <= centre[0] + 1; ++x) {
    for (int64_t y = centre[1] - 1; y <= centre[1] + 1; ++y) {
      // The three cells along z lie side by side.
      auto entry = std::lower_bound(entries_.begin(), entries_.end(), Cell{x, y, centre[2] - 1},
                                    [](const Entry& a, const Cell& cell) { return a.cell < cell; });
      const Cell last{x, y, centre[2] + 1};
      for (; entry != entries_.end() && entry->cell <= last; ++entry)
        if ((entry->point - p).squaredNorm() <= limit) return true;
    }
  }
  return false;
}

}  // namespace tetragauge
