// SPDX-License-Identifier: GPL-3.0-or-later
// The crossings of a line with a solid, in and out by turns. The triangles close, so that the line's hits on
// them do so; each hit on a curved face is replaced by the crossing of the true surface that it stands for.
// What the triangles do not have (a ray that grazes a bulge) counts only with its counterpart: alone it is
// the corner between an edge and the chord that stands for it, and would leave the line in the material for
// good.
#pragma once

#include <vector>

#include "host/solid/curved_faces.hpp"

namespace tetragauge {

// A line's hit on a triangle.
struct TriangleCrossing {
  Crossing crossing;
  bool is_curved = false;  // on a face whose true crossings are known
  bool is_flat = false;    // so flat to it that the surface may be passed (`is_flat`)
  double reach_mm = 0;     // the true crossing lies this near along the line
};

// `known`: of the true curved surfaces, ascending. `rounding_mm`: how far a hit's place may be off.
std::vector<Crossing> order_crossings(const Solid& solid, std::vector<TriangleCrossing> hits,
                                      const std::vector<Crossing>& known, double rounding_mm);

}  // namespace tetragauge
