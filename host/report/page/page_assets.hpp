// SPDX-License-Identifier: GPL-3.0-or-later
// What browser/ becomes at build time; page_assets.cpp is written by browser/build.js.
#pragma once

#include <string_view>

namespace tetragauge {

extern const std::string_view kPageStyle;   // CSS
extern const std::string_view kPageScript;  // one script, three.js within

}  // namespace tetragauge
