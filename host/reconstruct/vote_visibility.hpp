// SPDX-License-Identifier: GPL-3.0-or-later
// What each measuring ray says about the tetrahedra: air along its way, solid just behind its point.
// Soft visibility after Labatut, Pons, Keriven, Computer Graphics Forum 28 (2009) 2275, section 4.1, with the
// ray's own sigma instead of one for all.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reconstruct/average_points.hpp"
#include "host/reconstruct/tetrahedra.hpp"
#include "host/scan/scan.hpp"

namespace tetragauge {

// Votes are integers (1000 = one ray of typical sigma), so that sums do not depend on their order.
using Votes = int64_t;
constexpr Votes kOneRay = 1000;

// Of one cell. One line of the processor's cache, since rays touch cells far apart.
struct alignas(64) CellVotes {
  // Through facet i: rays that travel, light's way, from the neighbour across facet i into this cell, and so
  // speak against a surface there with the neighbour air and this cell solid: surely so far before or behind
  // their point, hardly within its noise.
  std::array<Votes, 4> entered_through{};
  Votes from_outside = 0;    // a ray came into the triangulation here
  Votes into_inside = 0;     // a ray ends here, three sigma beyond its point
  Votes air = 0, solid = 0;  // rays crossing on their way, and behind their point
};

struct Visibility {
  std::vector<CellVotes> cells;
  std::vector<uint8_t> crossed;  // per cell: a ray crossed it, whatever its weight (thesis's carving)
  size_t rays_walked = 0, rays_lost = 0;
};

// Equal rays of one vertex are walked once and count as many. In parallel.
Visibility vote_visibility(const Tetrahedra& tetrahedra, const Scan& scan, const AveragedPoints& averaged);

// The same for `tetrahedra` that have more vertices than `before` had (without rays): only rays on which
// cells have changed are walked again.
Visibility vote_again(const Tetrahedra& tetrahedra, const Scan& scan, const AveragedPoints& averaged,
                      const Tetrahedra& before, const Visibility& visibility_before);

}  // namespace tetragauge
