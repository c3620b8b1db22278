// SPDX-License-Identifier: GPL-3.0-or-later
// Which tetrahedra are air, which solid, by minimum cut over the rays' votes.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reconstruct/tetrahedra.hpp"
#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {

// Per cell 1: air, 0: solid. Infinite cells are air unless rays that end on their facet claim solid behind it
// (the underside of a sheet seen from one side only). Where rays are silent the smaller surface wins: every
// facet costs a hundredth of a ray per `point_area_mm2`, the area one point has to itself. Without it the
// noise layer keeps shells of solid with nothing behind them. It is too little to outvote rays: not a
// smoothing.
std::vector<uint8_t> label_cells(const Tetrahedra& tetrahedra, const Visibility& visibility,
                                 double point_area_mm2);

}  // namespace tetragauge
