// SPDX-License-Identifier: GPL-3.0-or-later
// What of the air about a part no beam of a scan can prove to be air: an oracle of the matrix, from the true
// model alone. What no ray saw counts as solid, so this volume is what any reconstruction adds.
#pragma once

#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/scan/scan.hpp"
#include "host/solid/ray_caster.hpp"

namespace tetragauge::bench {

struct Shadow {
  double dark_mm3 = 0;    // air within the convex hull that no beam from any view could pass to a point
  double missed_mm3 = 0;  // this, and air that beams could, but none of the scan comes within half a spacing
};

// `scan` without noise worth mentioning against `spacing_mm`, `T` from the model to it.
Shadow measure_shadow(const Solid& solid, const RayCaster& caster, const Scan& scan, const RigidTransform& T,
                      double spacing_mm, double max_incidence_rad);

// For each face the share of its area that no view reaches.
std::vector<double> dark_share(const Solid& solid, const RayCaster& caster, const Scan& scan,
                               const RigidTransform& T, double max_incidence_rad);

}  // namespace tetragauge::bench
