// SPDX-License-Identifier: GPL-3.0-or-later
// JSON files that people write: what a parser would pass over silently is an error here.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "host/base/result.hpp"

namespace tetragauge {

// Errors begin with `name`, and with the line and column where the text is not JSON: a key given twice in one
// object (of which one would win), a number that no double holds, lists nested beyond all use.
Result<nlohmann::json> parse_json(std::string_view text, const std::string& name);

}  // namespace tetragauge
