// SPDX-License-Identifier: GPL-3.0-or-later
// What a plan may ask for, whatever machine it is for.
#pragma once

#include <cstdint>

namespace tetragauge {

inline constexpr double kTableLowest_deg = -180, kTableHighest_deg = 360;  // soft limits
inline constexpr double kSlideLowest_mm = 0, kSlideHighest_mm = 300;
inline constexpr double kWindowReach_mm = 110;  // either side: what the mirrors reach and the cameras see
inline constexpr double kFinestPitch_mm = 0.02, kCoarsestPitch_mm = 50;
inline constexpr uint32_t kFewestSamples = 2, kMostSamples = 4096;

}  // namespace tetragauge
