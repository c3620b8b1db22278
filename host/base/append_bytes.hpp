// SPDX-License-Identifier: GPL-3.0-or-later
// A number's bytes at the end of a binary file's text, little-endian.
#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <string>

namespace tetragauge {

template <class T>
void append_bytes(std::string& out, T value) {
  static_assert(std::endian::native == std::endian::little, "files are written as numbers lie in memory");
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  out.append(bytes.data(), bytes.size());
}

}  // namespace tetragauge
