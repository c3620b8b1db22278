// SPDX-License-Identifier: GPL-3.0-or-later
// What an error quotes of a file.
#pragma once

#include <string>
#include <string_view>

namespace tetragauge {

// The beginning of `text`, some words at most, with '?' for every byte that is not printable ASCII: a
// terminal shows it as it is, whatever the file was.
std::string excerpt(std::string_view text);

}  // namespace tetragauge
