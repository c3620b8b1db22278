// SPDX-License-Identifier: GPL-3.0-or-later
// The thesis's rule: a tetrahedron is air as soon as one ray crosses it, and then two eliminations of what no
// ray happened to cross.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reconstruct/average_points.hpp"
#include "host/reconstruct/tetrahedra.hpp"
#include "host/reconstruct/vote_visibility.hpp"
#include "host/solid/ray_caster.hpp"

namespace tetragauge {

// Per cell 1: air, 0: solid. First elimination: tetrahedra that touch air and are long and flat, lower than
// three sigma of their vertices and ten times as long as that: what lies between noisy points of one face.
// Second, with a `model` in the scan's frame: rays from +-x, +-y, +-z to the centroid of each tetrahedron
// that is left; one that arrives makes it air.
std::vector<uint8_t> carve_cells(const Tetrahedra& tetrahedra, const Visibility& visibility,
                                 const AveragedPoints& averaged, const RayCaster* model = nullptr);

}  // namespace tetragauge
