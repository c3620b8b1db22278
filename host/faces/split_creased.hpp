// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "host/faces/assign_points.hpp"

namespace tetragauge {

// Two planes that meet at a small angle (a wall's draft against noise) may have grown into one region. A face
// is split along the straight crease that explains its points best, if two planes explain them better than
// one by more than chance, better than a smooth bow does, and stand at more than the angle by which a single
// face may bow.
struct Creased {
  Regions regions;             // to fit again: those of the faces, then the second halves
  std::vector<size_t> parted;  // per second half, the face it was split from
};
Creased split_creased(const Scan& scan, const Reconstruction& reconstruction, const FittedFaces& fitted,
                      const std::vector<size_t>& faces);

// Surface that turns by less than half a degree is one plane with a form error; a wall with one degree of
// draft must still be told from its neighbour.
constexpr double kFlatTurn = 0.0087;  // rad

}  // namespace tetragauge
