// SPDX-License-Identifier: GPL-3.0-or-later
// Embree as it is used here: rays about the middle of the part, one thread to build.
#pragma once

#include <embree3/rtcore.h>

#include "host/geometry/vec.hpp"

namespace tetragauge {

// Embree computes in float: coordinates and distances along a ray that starts at the part's box are right to
// this share of the box's diagonal.
inline constexpr double kFloatShare = 4e-7;

// A ray from `start` (relative to the scene's centre, within or near the box).
RTCRayHit ray_query(const Vec3& start, const Vec3& direction, double near, double far);

// Takes over the geometry and builds the tree.
void commit_scene(RTCScene scene, RTCGeometry geometry);

}  // namespace tetragauge
