// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "host/faces/assign_points.hpp"

namespace tetragauge {

// Patches of one plane with nothing measured between them (a face half in shadow) are one face, unless
// something proves them apart: a ray that crosses the plane between them, or points that rise from it there.
// Patches of fewer than `min_points` points stay as they are: nothing could prove them apart.
FittedFaces unite_patches(const Scan& scan, const Reconstruction& reconstruction, FittedFaces fitted,
                          size_t min_points);

}  // namespace tetragauge
