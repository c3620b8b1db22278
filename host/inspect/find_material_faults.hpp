// SPDX-License-Identifier: GPL-3.0-or-later
// Places within a model face where the rays prove material that is missing (they go through) or in excess
// (they stop short), whatever its shape: a pocket, a hole, a boss that the model does not have.
#pragma once

#include "host/inspect/join_set_ups.hpp"
#include "host/solid/face_outline.hpp"

namespace tetragauge {

// On faces with a tolerance that are not skipped and have not failed by themselves. A place is a fault when,
// within two spacings of a ray, at least 8 rays and most of all there miss the face by more than its limit
// and three sigma. So a feature must be some four spacings wide, and that far from an edge or across it, to
// be found for certain: `smallest_feature_mm`. Nothing is judged where the pose has a free direction: the
// model could be moved there. Reads `inspection.faces`, fills `inspection.material_faults` and
// `smallest_feature_mm`.
void find_material_faults(const Solid& model, const JoinedScan& joined,
                          const std::vector<FaceOutline>& outlines, const Tolerances& tolerances,
                          Inspection& inspection);

}  // namespace tetragauge
