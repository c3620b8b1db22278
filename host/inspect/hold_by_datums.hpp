// SPDX-License-Identifier: GPL-3.0-or-later
// The part held by its datum faces, one after the other (ISO 5459: primary, secondary, tertiary; 3-2-1).
#pragma once

#include "host/inspect/part_pose.hpp"

namespace tetragauge {

// `faces`: as measured in the poses of `set_ups`. Moves these poses so that the first datum's measured plane
// lies on its nominal one, the second's as well as turning and shifting along the first allow (least squares
// over its points), the third's as what is then left allows; what no datum holds stays as near to the best
// fit as its covariance asks. `share`: per face that of each set-up in its points. Where a datum was not
// measured nothing moves, and `alignment.problem` says so.
void hold_by_datums(const Solid& model, const std::vector<Datum>& datums,
                    const std::vector<FaceInspection>& faces, const std::vector<std::vector<double>>& share,
                    std::vector<SetUp>& set_ups, PartPose& pose, Alignment& alignment);

}  // namespace tetragauge
