// SPDX-License-Identifier: GPL-3.0-or-later
// How the part can stand on a table, after the thesis: it rests on those faces of its convex hull into which
// its centroid projects.
#pragma once

#include <vector>

#include "host/reconstruct/reconstruct.hpp"

namespace tetragauge {

struct RestingPosition {
  Vec3 down = Vec3::Zero();      // unit, part frame: points into the table
  double d_mm = 0;               // of the table's plane: down . x = d
  double height_mm = 0;          // of the centroid above the table
  double margin_mm = 0;          // of the centroid's projection to the nearest edge of the contact polygon
  double tipping_rad = 0;        // by how much the part must be tilted to fall over that edge
  std::vector<Vec3> contact_mm;  // the contact polygon, counter-clockwise seen from below
};

// The steadiest first. Hull vertices within four of their own sigmas of the table are contact: a scanned face
// touches it as a whole, and not with the three points that noise has pushed out most.
std::vector<RestingPosition> resting_positions(const Reconstruction& reconstruction);

}  // namespace tetragauge
