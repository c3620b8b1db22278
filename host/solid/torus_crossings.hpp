// SPDX-License-Identifier: GPL-3.0-or-later
// Where a line crosses a torus: a quartic, solved between the turning points of its distance.
#pragma once

#include <array>

#include "host/geometry/face.hpp"

namespace tetragauge {

struct TorusCrossings {
  std::array<double, 4> s{};        // p + s * direction, ascending
  std::array<bool, 4> is_inward{};  // into the tube
  size_t count = 0;
};

// `direction` is unit. Precondition: the face is a torus whose minor radius is less than its major one.
TorusCrossings torus_crossings(const Face& face, const Vec3& p, const Vec3& direction);

}  // namespace tetragauge
