// SPDX-License-Identifier: GPL-3.0-or-later
// What a few more vertices have changed in a triangulation.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reconstruct/tetrahedra.hpp"

namespace tetragauge {

class ChangedCells {
 public:
  // `after` has the vertices of `before`, under the same numbers, and more.
  ChangedCells(const Tetrahedra& before, const Tetrahedra& after);

  // Per cell of `after` the same cell's number in `before`; kNoCell: it was not there.
  const std::vector<uint32_t>& number_before() const { return number_before_; }
  // Then a ray that left the triangulation before may now go on in it.
  bool hull_has_changed() const { return hull_changed_; }
  // Whether the straight line from a to b may have crossed a cell that is gone. Errs to the safe side.
  bool may_be_on(const Vec3& a, const Vec3& b) const;

 private:
  struct Box {
    Vec3 low, high;
  };
  bool may_cross(size_t box, const Vec3& a, const Vec3& b) const;

  std::vector<uint32_t> number_before_;
  bool hull_changed_ = false;
  size_t leaves_ = 0;       // a power of two
  std::vector<Box> boxes_;  // binary tree: box k holds 2k and 2k + 1; leaves are cells that are gone
};

}  // namespace tetragauge
