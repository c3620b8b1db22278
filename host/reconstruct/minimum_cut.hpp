// SPDX-License-Identifier: GPL-3.0-or-later
// Minimum cut over tetrahedra: the cheapest division into air and solid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/reconstruct/tetrahedra.hpp"
#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {

struct CutProblem {
  std::vector<Votes> for_air;  // per cell: positive, what it costs to call it solid; negative, air
  std::vector<std::array<Votes, 4>> cost;  // per cell and facet i: neighbour i air while this cell is solid
};

// Per cell 1: air, 0: solid. Among all cheapest divisions the one with the least air.
std::vector<uint8_t> minimum_cut(const Tetrahedra& tetrahedra, CutProblem problem);

}  // namespace tetragauge
