// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/base/excerpt.hpp"

#include <algorithm>

namespace tetragauge {

std::string excerpt(std::string_view text) {
  constexpr size_t kLongest = 40;
  std::string shown(text.substr(0, kLongest));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.size() > kLongest ? shown + "..." : shown;
}

}  // namespace tetragauge
