// SPDX-License-Identifier: GPL-3.0-or-later
// Tetrahedra at the surface that might as well be the other thing: where another ray would say most.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reconstruct/extract_surface.hpp"
#include "host/reconstruct/reconstruct.hpp"
#include "host/reconstruct/tetrahedra.hpp"
#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {

// The share of a cell's votes that agree with its label, 0..1; 0 where rays are silent.
float cell_confidence(const CellVotes& votes, bool is_air);

// Cells at the surface that their rays contradict (less than three quarters of the votes agree with the
// label), and solid behind surface that no ray has touched: filling, not knowledge. Largest volume first,
// then largest area of surface: what changes hands if the label is wrong.
std::vector<DoubtfulTetrahedron> rank_doubtful(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                                               const Visibility& visibility, const Surface& surface);

}  // namespace tetragauge
