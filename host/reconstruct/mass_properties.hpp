// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "host/reconstruct/tetrahedra.hpp"

namespace tetragauge {

struct MassProperties {
  double volume_mm3 = 0;
  Vec3 centroid_mm = Vec3::Zero();
  Mat3 inertia_mm5 = Mat3::Zero();  // about the centroid, density 1
};

// Of the finite cells that are not air; the second moments of a tetrahedron are exact (Tonon, J. Math. Stat.
// 1 (2005) 8).
MassProperties mass_properties(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air);

}  // namespace tetragauge
