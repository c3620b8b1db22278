// SPDX-License-Identifier: GPL-3.0-or-later
// From light on a duolateral detector to converter codes: four electrode currents, shot and amplifier noise,
// speckle, ambient light, gain, rails, quantisation.
#pragma once

#include <array>
#include <cstdint>

#include "sim/numbers.hpp"
#include "sim/spot.hpp"

namespace tetragauge::sim {

struct DetectorCodes {
  int16_t x1 = 0, x2 = 0, y1 = 0, y2 = 0;
};

// Displacement of the spot's centre by speckle, share of the detector's half side: one draw for each place
// and camera, so averaging samples of one place does not lower it. `key` belongs to the place and the camera.
SpotImage add_speckle(const Numbers& numbers, const TrueCamera& camera, SpotImage image, uint64_t key);

// Amplifiers and converter of one detector.
class DetectorElectronics {
 public:
  explicit DetectorElectronics(const Numbers& numbers);

  // One sample. `lit`: 0 .. 1, how far the laser is on. `flash_A`: ambient light above the steady one. `key`
  // belongs to the place, the sample and the camera.
  DetectorCodes sample(const SpotImage& image, double lit, double flash_A, uint64_t key) const;

 private:
  int16_t convert(double current_A, double noise) const;

  double ambient_A_, steps_per_A_;
  double dark_variance_steps2_, shot_variance_steps2_A_;  // of one sample: without light, and for each ampere
  double rail_steps_, code_per_step_;
};

}  // namespace tetragauge::sim
