// SPDX-License-Identifier: GPL-3.0-or-later
// The light of one beam: a finite spot on part or table, and what of it reaches each camera's detector.
#pragma once

#include <array>

#include "sim/numbers.hpp"
#include "sim/part_on_table.hpp"
#include "sim/true_geometry.hpp"

namespace tetragauge::sim {

// What one detector receives of the spot.
struct SpotImage {
  double current_A = 0;      // whole photocurrent; 0: the camera does not see the spot
  double x = 0, y = 0;       // centre of gravity on the detector, share of its half side
  double magnification = 0;  // detector mm per mm at the spot
};

using SpotImages = std::array<SpotImage, 2>;

// `beam` in the machine frame. A Gaussian beam is sampled by 7 sub-rays, so that at an edge part of the spot
// lies on one face and part on another (or nowhere), and the detectors see the mixture.
SpotImages image_spot(const Numbers& numbers, const TrueGeometry& geometry, const PartOnTable& part,
                      const RigidTransform& T_machine_part, const Line& beam);

}  // namespace tetragauge::sim
