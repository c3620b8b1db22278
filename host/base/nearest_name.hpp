// SPDX-License-Identifier: GPL-3.0-or-later
// What a mistyped key or option probably meant, for error messages.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace tetragauge {

// The known name with the fewest insertions, deletions and replacements from `name` (Levenshtein 1966); the
// first of equals. Empty when `known` is empty.
std::string nearest_name(std::string_view name, std::span<const std::string_view> known);

}  // namespace tetragauge
