// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/simulate/counter_noise.hpp"

#include <cmath>
#include <numbers>

namespace tetragauge {
namespace {

// Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014: the step and the mixing
// of SplitMix64.
constexpr uint64_t kGoldenGamma = 0x9E3779B97F4A7C15u;

uint64_t mix(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

// In (0, 1), never an end of it.
double unit(uint64_t bits) {
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

uint64_t state_of(uint64_t seed, uint64_t view, uint64_t ray) {
  uint64_t state = mix(seed + kGoldenGamma);
  state = mix(state ^ mix(view + 2 * kGoldenGamma));
  return mix(state ^ mix(ray + 3 * kGoldenGamma));
}

}  // namespace

double counter_uniform(uint64_t seed, uint64_t view, uint64_t ray, uint64_t draw) {
  return unit(mix(state_of(seed, view, ray) + draw * kGoldenGamma));
}

double counter_normal(uint64_t seed, uint64_t view, uint64_t ray) {
  const uint64_t state = state_of(seed, view, ray);
  // Box and Muller, Ann. Math. Stat. 29 (1958) 610.
  const double radius = std::sqrt(-2 * std::log(unit(state)));
  return radius * std::cos(2 * std::numbers::pi * unit(mix(state + kGoldenGamma)));
}

}  // namespace tetragauge
