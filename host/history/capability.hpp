// SPDX-License-Identifier: GPL-3.0-or-later
// How a quantity spreads over many parts, against its limits.
//
//   Capability c = capability_of(values, -0.1, 0.1);
//   if (c.cpk) print(*c.cpk, c.cpk_interval->low, c.cpk_interval->high);
//
// s is the standard deviation over all parts with n - 1 (what ISO 22514-2 calls Pp and Ppk when the process
// is not shown to be stable; the run charts show whether it is).
//   Cp  = (upper - lower) / 6 s. Its interval is exact for normal values: (n - 1) s^2 / sigma^2 is chi-square
//         with n - 1 degrees of freedom (Chou, Owen & Borrego 1990, p. 224).
//   Cpk = the smaller of (upper - mean) / 3 s and (mean - lower) / 3 s. Its interval is Bissell's (Applied
//         Statistics 39 (1990), 331-340): Cpk +- z sqrt(1 / 9n + Cpk^2 / 2(n - 1)).
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace tetragauge {

// With less the intervals are so wide that the indices mislead.
inline constexpr size_t kFewestForCapability = 25;

struct Interval {
  double low = 0, high = 0;
};

struct Capability {
  size_t n = 0;
  double mean = 0, s = 0, min = 0, max = 0;  // 0 with n = 0; s is 0 with n = 1
  // None with n below kFewestForCapability, with s = 0, or without the limits: Cp needs both, Cpk one.
  std::optional<double> cp{}, cpk{};
  std::optional<Interval> cp_interval{}, cpk_interval{};
};

Capability capability_of(std::span<const double> values, std::optional<double> lower,
                         std::optional<double> upper, double confidence = 0.95);

}  // namespace tetragauge
