// SPDX-License-Identifier: GPL-3.0-or-later
// Noise that is a pure function of where it is used, not of when it is drawn: equal for any thread count.
#pragma once

#include <cstdint>

namespace tetragauge {

// A value evenly spread over (0, 1) for draw `draw` of beam `ray` of view `view`.
double counter_uniform(uint64_t seed, uint64_t view, uint64_t ray, uint64_t draw);

// A standard normal value for beam `ray` of view `view`.
double counter_normal(uint64_t seed, uint64_t view, uint64_t ray);

}  // namespace tetragauge
