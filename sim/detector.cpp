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

DetectorElectronics::DetectorElectronics(const Numbers& n, size_t camera)
    : steps_per_A_(n.gain_V_A * std::ldexp(1.0, n.converter_bits - 1) / n.full_scale_V),
      rail_steps_(std::ldexp(1.0, n.converter_bits - 1)),
      code_per_step_(std::ldexp(1.0, 16 - n.converter_bits)) {
  const double steps2_per_A2_Hz = steps_per_A_ * steps_per_A_ * n.noise_bandwidth_Hz;
  dark_variance_steps2_ =
      dark_noise_A2_Hz(n) * steps2_per_A2_Hz + n.converter_noise_lsb * n.converter_noise_lsb;
  shot_variance_steps2_A_ = 2 * kElectronCharge_C * steps2_per_A2_Hz;
  // The two shapes a converter's curve usually has, mixed otherwise in each channel of this machine; together
  // they stay within the limit.
  for (size_t channel = 0; channel < non_linearity_.size(); ++channel) {
    const uint64_t draw = mix_bits(4 * camera + channel);
    const double mix = static_cast<double>(draw >> 11) * 0x1p-53;
    non_linearity_[channel] = {n.converter_inl_lsb * mix * ((draw & 1) != 0 ? 1 : -1),
                               n.converter_inl_lsb * (1 - mix) * ((draw & 2) != 0 ? 1 : -1)};
  }
}

int16_t DetectorElectronics::convert(size_t channel, double current_A, double noise) const {
  const double sigma_steps =
      std::sqrt(dark_variance_steps2_ + shot_variance_steps2_A_ * std::max(current_A, 0.0));
  const double true_steps = current_A * steps_per_A_ + noise * sigma_steps;
  const double x = std::clamp(true_steps / rail_steps_, -1.0, 1.0);
  const NonLinearity& curve = non_linearity_[channel];
  const double error = curve.bow * (1 - x * x) + curve.s * std::sin(std::numbers::pi * x);
  const double step = std::floor(true_steps + error + 0.5);
  // Codes are left-aligned to 16 bits, as the board delivers them.
  return static_cast<int16_t>(std::clamp(step, -rail_steps_, rail_steps_ - 1) * code_per_step_);
}

DetectorCodes DetectorElectronics::sample(const SpotImage& image, double lit, double ambient_A,
                                          uint64_t key) const {
  // Each pair of electrodes carries the whole photocurrent, shared by the spot's place.
  const double half = 0.5 * lit * image.current_A, ambient = 0.5 * ambient_A;
  const auto [nx1, nx2] = normal_pair(combine_key(key, 0));
  const auto [ny1, ny2] = normal_pair(combine_key(key, 1));
  return {convert(0, half * (1 - image.x) + ambient, nx1), convert(1, half * (1 + image.x) + ambient, nx2),
          convert(2, half * (1 - image.y) + ambient, ny1), convert(3, half * (1 + image.y) + ambient, ny2)};
}

}  // namespace tetragauge::sim
