// SPDX-License-Identifier: GPL-3.0-or-later
// What the points say of the deviation at each vertex of the drawn model: the colours of the picture.
#pragma once

#include <span>
#include <vector>

#include "host/report/page/display_mesh.hpp"
#include "host/report/report.hpp"

namespace tetragauge {

// Per vertex the mean of its face's points about it, mm, + = excess material, over as many as it takes for
// noise to be calm beside the limit; NaN where there are none within 2.5 of the face's point spacings: not
// measured there. For the eye: verdicts come from the fits.
std::vector<float> deviation_field(const DisplayMesh& mesh, const Report& report,
                                   std::span<const Vec3> points_in_model_mm);

}  // namespace tetragauge
