// SPDX-License-Identifier: GPL-3.0-or-later
// What the page's script works on: the keys of report.json, and the shapes that it draws.
#pragma once

#include <nlohmann/json.hpp>

#include "host/report/report.hpp"

namespace tetragauge {

// `report` is report_json() without timing_s. browser/data.js reads it back, key by key.
nlohmann::ordered_json page_data(const Report& report, nlohmann::ordered_json json);

}  // namespace tetragauge
