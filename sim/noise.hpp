// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers that are a pure function of what they belong to, not of when they are drawn: the same seed,
// place, sample and channel give the same number, in whatever order samples are taken. Two visits of one
// place therefore see the same noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace tetragauge::sim {

// SplitMix64's finaliser (Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014): a
// bijection on 64 bits in which every input bit reaches every output bit.
constexpr uint64_t mix_bits(uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

constexpr uint64_t combine_key(uint64_t key, uint64_t next) {
  return mix_bits(key ^ mix_bits(next));
}

// Two independent standard normal numbers (Box and Muller, Ann. Math. Stat. 29 (1958) 610).
inline std::pair<double, double> normal_pair(uint64_t key) {
  const uint64_t a = mix_bits(key), b = mix_bits(a ^ 0x5851f42d4c957f2du);
  const double u = (static_cast<double>(a >> 11) + 0.5) * 0x1p-53;  // in (0, 1)
  const double radius = std::sqrt(-2.0 * std::log(u));
  const double angle = 2.0 * std::numbers::pi * (static_cast<double>(b >> 11) * 0x1p-53);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace tetragauge::sim
