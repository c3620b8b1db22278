// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles that do not close where a face is pinched: a hole that touches the face's edge, or runs beyond it
// by less than the file's tolerance, leaves a stretch of no width that the two faces mesh differently.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/geometry/vec.hpp"

namespace tetragauge {

// Whether every edge is run as often one way as the other.
bool is_closed(const std::vector<std::array<uint32_t, 3>>& triangles);

// The vertex that each vertex is to become so that the triangles close: those nearer than `reach_mm` to an
// open edge's ends are drawn together, no further than it takes. Empty if that does not close them.
// `vertices` are sorted by x.
std::vector<uint32_t> close_pinches(const std::vector<Vec3>& vertices,
                                    const std::vector<std::array<uint32_t, 3>>& triangles, double reach_mm);

}  // namespace tetragauge
