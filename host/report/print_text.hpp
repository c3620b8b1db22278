// SPDX-License-Identifier: GPL-3.0-or-later
// Lines of report.txt.
#pragma once

#include <string>

namespace tetragauge {

inline constexpr size_t kColumns = 100;

[[gnu::format(printf, 1, 2)]] std::string print(const char* format, ...);

// Breaks at spaces; lines after the first are indented.
std::string wrapped(const std::string& text);

}  // namespace tetragauge
