// SPDX-License-Identifier: GPL-3.0-or-later
// The match for parts with hardly a plane and for scans too coarse for planes: raw points to the surface.
#pragma once

#include "host/match/match.hpp"

namespace tetragauge {

struct SurfaceMatch {
  Match match;
  double against = 0;  // rays that speak against the pose, as a share (share_against)
};

// `known`: poses found by other means; they compete with those found here. Error (undecided): in no pose do
// the points lie on the surface.
Result<SurfaceMatch> match_surface(const Solid& model, const RayCaster& caster, const Scan& scan,
                                   const FaceList& measured, const MatchOptions& options,
                                   const std::vector<RigidTransform>& known);

}  // namespace tetragauge
