// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/detector.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/noise.hpp"

namespace tetragauge::sim {
namespace {

constexpr double kElectronCharge_C = 1.602176634e-19;
constexpr double kBoltzmann_J_K = 1.380649e-23;

// Noise of one electrode's current, A^2/Hz, without light: thermal noise of the resistive layer, 4 k T / R,
// and the amplifier's voltage noise across the same resistance.
double dark_noise_A2_Hz(const Numbers& n) {
  const double amplifier = n.amplifier_voltage_noise_V / n.electrode_resistance_ohm;
  return 4 * kBoltzmann_J_K * n.temperature_K / n.electrode_resistance_ohm + amplifier * amplifier;
}

int16_t convert(const Numbers& n, double current_A, double noise) {
  const double step_V = n.full_scale_V / std::ldexp(1.0, n.converter_bits - 1);
  const double variance_A2 =
      (dark_noise_A2_Hz(n) + 2 * kElectronCharge_C * std::max(current_A, 0.0)) * n.noise_bandwidth_Hz;
  const double noise_lsb = std::hypot(std::sqrt(variance_A2) * n.gain_V_A / step_V, n.converter_noise_lsb);
  const double code = std::floor(current_A * n.gain_V_A / step_V + noise * noise_lsb + 0.5);
  const double rail = std::ldexp(1.0, n.converter_bits - 1);
  // Codes are left-aligned to 16 bits, as the board delivers them.
  return static_cast<int16_t>(std::clamp(code, -rail, rail - 1) * std::ldexp(1.0, 16 - n.converter_bits));
}

}  // namespace

SpotImage add_speckle(const Numbers& n, const TrueCamera& camera, SpotImage image, uint64_t key) {
  if (image.current_A <= 0) return image;
  // Dorsch, Haeusler and Herrmann, Appl. Opt. 33 (1994) 1306: the centre of gravity of a laser spot wanders
  // sideways by C lambda / (2 pi sin u), u the half angle of the observing aperture seen from the spot.
  const double distance = camera.focal_mm / image.magnification;
  const double sin_u = n.aperture_radius_mm / std::hypot(distance, n.aperture_radius_mm);
  const double at_spot_mm = n.speckle_contrast * n.wavelength_mm / (2 * std::numbers::pi * sin_u);
  const double on_detector = at_spot_mm * image.magnification / camera.half_size_mm;
  const auto [nx, ny] = normal_pair(key);
  image.x += on_detector * nx;
  image.y += on_detector * ny;
  return image;
}

DetectorCodes sample_detector(const Numbers& n, const SpotImage& image, double lit, uint64_t key) {
  // Each pair of electrodes carries the whole photocurrent, shared by the spot's place; ambient light is
  // spread evenly.
  const double spot = lit * image.current_A, ambient = 0.5 * n.ambient_A;
  const auto [nx1, nx2] = normal_pair(combine_key(key, 0));
  const auto [ny1, ny2] = normal_pair(combine_key(key, 1));
  return {
      convert(n, 0.5 * spot * (1 - image.x) + ambient, nx1),
      convert(n, 0.5 * spot * (1 + image.x) + ambient, nx2),
      convert(n, 0.5 * spot * (1 - image.y) + ambient, ny1),
      convert(n, 0.5 * spot * (1 + image.y) + ambient, ny2),
  };
}

}  // namespace tetragauge::sim
