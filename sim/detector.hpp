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
  // `camera` (0 or 1): each channel has its own non-linearity.
  DetectorElectronics(const Numbers& numbers, size_t camera);

  // One sample. `lit`: 0 .. 1, how far the laser is on. `ambient_A`: of the detector, spread over it. `key`
  // belongs to the place, the sample and the camera.
  DetectorCodes sample(const SpotImage& image, double lit, double ambient_A, uint64_t key) const;

 private:
  int16_t convert(size_t channel, double current_A, double noise) const;

  // Of one channel: bow (1 - x^2) + s sin(pi x), x the share of full scale; steps.
  struct NonLinearity {
    double bow = 0, s = 0;
  };

  double steps_per_A_;
  std::array<NonLinearity, 4> non_linearity_;
  double dark_variance_steps2_, shot_variance_steps2_A_;  // of one sample: without light, and for each ampere
  double rail_steps_, code_per_step_;
};

}  // namespace tetragauge::sim
