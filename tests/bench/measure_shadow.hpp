// SPDX-License-Identifier: GPL-3.0-or-later
// What of the air about a part no beam of a scan can prove to be air: an oracle of the matrix, from the true
// model alone. What no ray saw counts as solid, so this volume is what any reconstruction adds.
#pragma once

#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/scan/scan.hpp"
#include "host/solid/ray_caster.hpp"

namespace tetragauge::bench {

// Volume of the air within the convex hull through which no beam from any of the scan's views could pass to a
// point, however many beams there are. `T` from the model to the scan.
double dark_air_mm3(const Solid& solid, const RayCaster& caster, const Scan& scan, const RigidTransform& T,
                    double max_incidence_rad);

// For each face the share of its area that no view reaches.
std::vector<double> dark_share(const Solid& solid, const RayCaster& caster, const Scan& scan,
                               const RigidTransform& T, double max_incidence_rad);

}  // namespace tetragauge::bench
