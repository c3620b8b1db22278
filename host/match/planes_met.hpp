// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "host/match/match.hpp"
#include "host/match/rank_poses.hpp"

namespace tetragauge {

// The measured faces again, each that has a partner fitted to those of its points whose rays meet that
// partner's surface, in the first of the poses in which it has one. Where a plane goes over into a fillet
// without an edge, the first strip of the fillet passes for the plane within the noise, and the plane leans;
// where a ray meets the model does not depend on the noise along it.
FaceList planes_met(const Solid& solid, const RayCaster& caster, const Scan& scan, const MeasuredFaces& faces,
                    const MatchInput& input, const std::vector<RankedPose>& poses);

}  // namespace tetragauge
