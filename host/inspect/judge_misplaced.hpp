// SPDX-License-Identifier: GPL-3.0-or-later
// Features of the right shape in the wrong place.
#pragma once

#include "host/inspect/inspect.hpp"
#include "host/solid/face_outline.hpp"

namespace tetragauge {

// The faces of a misplaced feature are not missing: each says where its feature stands, and one that lies
// farther from its place than its limit allows fails, whether or not it could be measured against the model.
void judge_misplaced(const Solid& model, const std::vector<FaceOutline>& outlines,
                     const std::vector<SetUp>& set_ups, const Tolerances& tolerances, Inspection& inspection);

}  // namespace tetragauge
