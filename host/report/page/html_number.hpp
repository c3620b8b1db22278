// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of report.json as a person reads them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tetragauge {

// "0.402", with_sign "+0.402"; an en dash when there is none. A true minus sign, never -0.
std::string html_number(const nlohmann::ordered_json& value, int decimals, bool with_sign = false);

// value.at("a").at("b") ..., null where a key is missing.
nlohmann::ordered_json at_path(const nlohmann::ordered_json& json, std::initializer_list<const char*> keys);

}  // namespace tetragauge
