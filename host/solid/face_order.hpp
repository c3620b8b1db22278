// SPDX-License-Identifier: GPL-3.0-or-later
// The canonical order of a solid's faces, and which of them lie on one surface.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/geometry/face.hpp"

namespace tetragauge {

// Faces are sorted by it: type, direction, place, centroid, area, in steps far above rounding.
using FaceKey = std::array<int64_t, 14>;
FaceKey canonical_key(const Face& face);

// Whether two faces lie on one surface, as exactly as exporters, Booleans and six-digit matrices leave them.
bool is_same_surface(const Face& a, const Face& b);

// Surface ids from 1 in the order of the faces.
void number_surfaces(std::vector<Face>& faces, const std::function<bool(const Face&, const Face&)>& is_same);

}  // namespace tetragauge
