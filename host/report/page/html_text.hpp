// SPDX-License-Identifier: GPL-3.0-or-later
// Text that comes from files, made safe in a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace tetragauge {

// Between tags and within quoted attributes.
std::string html_text(std::string_view text);

// Within <script type="application/json">: nothing in it ends the element or opens a comment.
std::string script_json(const nlohmann::ordered_json& json);

}  // namespace tetragauge
