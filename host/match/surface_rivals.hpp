// SPDX-License-Identifier: GPL-3.0-or-later
// Poses that the points taken one by one do not tell apart, with what whole faces say: a boss too small lies
// off the model wherever it stands near its place, but only in its place all of it by the same.
#pragma once

#include <vector>

#include "host/match/settle_on_surface.hpp"

namespace tetragauge {

// Each of the `others` as good as it can be made, none like another or the chosen one, in the order given.
std::vector<NearbyPose> surface_rivals(const SurfaceProblem& problem, const SettledPose& chosen,
                                       const std::vector<RigidTransform>& others,
                                       const SurfaceScatter& scatter, double most_out_mm);

}  // namespace tetragauge
