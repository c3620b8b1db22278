// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/packed.hpp"

#include <algorithm>
#include <cmath>

namespace tetragauge {

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t k = 0; k < bytes.size(); k += 3) {
    uint32_t three = 0;
    for (size_t i = 0; i < 3; ++i)
      three = three << 8 | (k + i < bytes.size() ? static_cast<unsigned char>(bytes[k + i]) : 0u);
    for (size_t i = 0; i < 4; ++i) text += k + i > bytes.size() ? '=' : digits[three >> (18 - 6 * i) & 63];
  }
  return text;
}

std::string packed_lengths(std::span<const float> lengths_mm, double unit_mm) {
  std::string bytes;
  for (const float length : lengths_mm) {
    int16_t steps = kPackedNone;
    if (std::isinf(length)) {
      steps = length > 0 ? 32767 : -32767;
    } else if (!std::isnan(length)) {
      steps = static_cast<int16_t>(
          std::clamp(std::round(static_cast<double>(length) / unit_mm), -32766.0, 32766.0));
    }
    append_bytes(bytes, steps);
  }
  return base64(bytes);
}

bool Box::holds(const Vec3& p) const {
  return (p.array() >= low_mm.array()).all() && (p.array() <= high_mm.array()).all();
}

std::string packed_places(std::span<const Vec3> places_mm, const Box& box) {
  std::string bytes;
  for (const Vec3& place : places_mm) {
    for (int k = 0; k < 3; ++k) {
      const double share = (place[k] - box.low_mm[k]) / std::max(1e-12, box.high_mm[k] - box.low_mm[k]);
      append_bytes(bytes, static_cast<uint16_t>(std::lround(65535 * std::clamp(share, 0.0, 1.0))));
    }
  }
  return base64(bytes);
}

}  // namespace tetragauge
