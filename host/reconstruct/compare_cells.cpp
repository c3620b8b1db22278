// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/compare_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tetragauge {

ChangedCells::ChangedCells(const Tetrahedra& before, const Tetrahedra& after)
    : number_before_(after.cells.size(), kNoCell) {
  // Both lists are sorted by the cells' vertices.
  std::vector<uint32_t> gone;
  uint32_t old = 0;
  for (uint32_t c = 0; c < after.cells.size(); ++c) {
    for (; old < before.cells.size() && before.cells[old].vertex < after.cells[c].vertex; ++old)
      gone.push_back(old);
    if (old < before.cells.size() && before.cells[old].vertex == after.cells[c].vertex)
      number_before_[c] = old++;
  }
  for (; old < before.cells.size(); ++old) gone.push_back(old);

  leaves_ = std::bit_ceil(std::max<size_t>(gone.size(), 1));
  const Box none{Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
  boxes_.assign(2 * leaves_, none);
  for (size_t k = 0; k < gone.size(); ++k) {
    const Cell& cell = before.cells[gone[k]];
    if (cell.is_infinite()) {
      hull_changed_ = true;
      continue;
    }
    Box& box = boxes_[leaves_ + k];
    for (const uint32_t v : cell.vertex) {
      box.low = box.low.cwiseMin(before.vertices[v]);
      box.high = box.high.cwiseMax(before.vertices[v]);
    }
    // Far more than rounding in may_cross, far less than a cell.
    const Vec3 margin =
        1e-9 * (box.high - box.low + box.low.cwiseAbs() + box.high.cwiseAbs()) + Vec3::Constant(1e-9);
    box.low -= margin;
    box.high += margin;
  }
  for (size_t k = leaves_ - 1; k > 0; --k)
    boxes_[k] = {boxes_[2 * k].low.cwiseMin(boxes_[2 * k + 1].low),
                 boxes_[2 * k].high.cwiseMax(boxes_[2 * k + 1].high)};
}

// Separating axes of a segment and a box: the three of space, and their products with the segment's
// direction.
bool ChangedCells::may_cross(size_t k, const Vec3& a, const Vec3& b) const {
  const Box& box = boxes_[k];
  if (!(box.low.x() <= box.high.x())) return false;  // empty
  const Vec3 centre = 0.5 * (box.low + box.high), half = 0.5 * (box.high - box.low);
  const Vec3 middle = 0.5 * (a + b) - centre, reach = 0.5 * (b - a), size = reach.cwiseAbs();
  if (((middle.cwiseAbs() - half - size).array() > 0).any()) return false;
  // Rounding of the products: of their largest terms.
  const double rounding = 1e-12 * (middle.cwiseAbs().sum() + half.sum()) * size.sum();
  const Vec3 across = middle.cross(reach).cwiseAbs();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, l = (i + 2) % 3;
    if (across[i] > half[j] * size[l] + half[l] * size[j] + rounding) return false;
  }
  return true;
}

bool ChangedCells::may_be_on(const Vec3& a, const Vec3& b) const {
  size_t k = 1;
  for (;;) {  // depth first; after a left box comes its right one, after a right one its parent's next
    if (may_cross(k, a, b)) {
      if (k >= leaves_) return true;
      k *= 2;
      continue;
    }
    while (k & 1) k /= 2;
    if (k == 0) return false;
    ++k;
  }
}

}  // namespace tetragauge
