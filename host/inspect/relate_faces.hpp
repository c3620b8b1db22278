// SPDX-License-Identifier: GPL-3.0-or-later
// Angle and distance between plane faces against nominal. They need no pose.
#pragma once

#include "host/inspect/inspect.hpp"

namespace tetragauge {

// Of measured planes: neighbours (that share an edge) their angle, parallel ones their angle and distance. By
// first face, then second.
std::vector<FaceRelation> relate_faces(const Solid& model, const std::vector<FaceInspection>& faces);

}  // namespace tetragauge
