// SPDX-License-Identifier: GPL-3.0-or-later
// What the emulated machine is made of, apart from its geometry: light, detectors, amplifiers, converters,
// mirrors, stage. Every default is from published data of a real part; sources and the sigma that follows by
// hand stand in docs/machine.md, "Emulated machine: numbers".
#pragma once

#include <cstdint>

#include "sim/mirror.hpp"

namespace tetragauge::sim {

struct Numbers {
  // Laser: red diode, collimated and focused at the middle of the working volume.
  double laser_W = 4.5e-3;
  double wavelength_mm = 650e-6;
  double waist_mm = 0.08;          // 1/e^2 radius at the focus
  double focus_distance_mm = 350;  // from the last mirror
  double laser_rise_s = 10e-6;     // time constant of switching, with the converter filter behind it

  // Surfaces: Lambertian, the share of light sent back.
  double part_albedo = 0.7;    // matt white spray
  double table_albedo = 0.04;  // black anodised
  double table_radius_mm = 90;

  // Lens and duolateral detector.
  double aperture_radius_mm = 8.75;        // f/2 at 35 mm
  double lens_transmission = 0.9;          // with the band filter
  double responsivity_A_W = 0.42;          // silicon at 650 nm
  double electrode_resistance_ohm = 10e3;  // between the electrodes of a pair
  double temperature_K = 300;
  double amplifier_voltage_noise_V = 8e-9;  // per sqrt(Hz)
  double speckle_contrast = 1;
  double ambient_A = 0.1e-6;     // lit room through the band filter, spread over the detector
  double ambient_flicker = 0;    // share of it that swings with the mains' half waves (100 Hz)
  double ambient_drift_A_s = 0;  // what it grows by in a second

  // Amplifier and converter: 16 bit, +-full scale, all channels at once.
  double gain_V_A = 1e6;
  double full_scale_V = 5;
  int converter_bits = 16;
  double noise_bandwidth_Hz = 17e3;   // the converter's own second-order filter
  double converter_noise_lsb = 0.67;  // rms
  double converter_inl_lsb = 0.5;     // integral non-linearity of the worst channel, peak; of its own steps

  // Mirrors.
  MirrorDynamics mirror{.natural_rad_s = 15300, .damping = 0.75, .slew_rad_s = 140};
  double mirror_repeatability_rad = 8e-6;  // rms, mechanical, one draw for each place
  double rad_per_mirror_code = 6e-6;       // mechanical; 16-bit converter

  // Stage: geared to 0.01 degrees and 5 um a step, with play behind the motor; where the switches, on the
  // moving side, close.
  int32_t table_steps_per_turn = 36'000;
  double slide_mm_per_step = 0.005;
  int32_t table_backlash_steps = 3, slide_backlash_steps = 2;
  int32_t table_home_steps = -18'100, slide_home_steps = -400;
  int32_t slide_limit_low_steps = -600, slide_limit_high_steps = 60'400;
  int32_t table_start_steps = 2'500, slide_start_steps = 3'000;  // where the axes stand when power comes on
};

}  // namespace tetragauge::sim
