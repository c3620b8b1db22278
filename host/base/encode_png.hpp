// SPDX-License-Identifier: GPL-3.0-or-later
// PNG from pixels in memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace tetragauge {

using Colour = std::array<uint8_t, 3>;  // red, green, blue

// Rows from the top, left to right; "" for a picture without pixels. The same pixels give the same bytes.
std::string encode_png(std::span<const Colour> pixels, size_t width);

}  // namespace tetragauge
