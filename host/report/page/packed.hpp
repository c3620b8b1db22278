// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays of numbers as JSON can carry them: little-endian bytes in base64.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "host/base/append_bytes.hpp"
#include "host/geometry/vec.hpp"

namespace tetragauge {

std::string base64(std::string_view bytes);  // RFC 4648, padded

template <class T, class Range>
std::string packed(const Range& values) {
  std::string bytes;
  for (const auto& value : values) append_bytes(bytes, static_cast<T>(value));
  return base64(bytes);
}

// Lengths in steps of `unit_mm`, as int16: clamped to +-32,766 steps; NaN is kPackedNone, infinities pass as
// +-32,767.
inline constexpr int16_t kPackedNone = std::numeric_limits<int16_t>::min();
std::string packed_lengths(std::span<const float> lengths_mm, double unit_mm);

// Places in a box, as three uint16 each: 0 and 65,535 are its sides.
struct Box {
  Vec3 low_mm = Vec3::Zero(), high_mm = Vec3::Zero();
  bool holds(const Vec3& p) const;
};
std::string packed_places(std::span<const Vec3> places_mm, const Box& box);

}  // namespace tetragauge
