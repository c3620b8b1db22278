// SPDX-License-Identifier: GPL-3.0-or-later
// More vertices where tetrahedra are too coarse for what the rays say. Where surface lies in shadow there are
// no points, and one tetrahedron may reach from a measured face, through the solid behind it, out into the
// air before the shadow. Rays cross it there, and it cannot be both: as air it takes the measured face away.
// Points inside the solid split it.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reconstruct/average_points.hpp"
#include "host/reconstruct/tetrahedra.hpp"
#include "host/reconstruct/vote_visibility.hpp"

namespace tetragauge {

// Behind each measured triangle that has air on both sides though no ray went through it, if the tetrahedron
// behind it is deeper than two spacings: points one, two, four ... spacings behind the triangle's middle, up
// to half that depth. Measured: its corners were seen from its front, and it is neither longer than three
// spacings (such ones close the mouths of slots) nor narrower than a quarter (such ones stand on edge in the
// noise). In order of the tetrahedra; mm.
std::vector<Vec3> find_supports(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air,
                                const Visibility& visibility, const AveragedPoints& averaged);

// Adds them as vertices without rays: their sigma is a spacing, they were seen from nowhere (ray zero).
void add_supports(const std::vector<Vec3>& supports, AveragedPoints& averaged);

}  // namespace tetragauge
