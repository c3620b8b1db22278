// SPDX-License-Identifier: GPL-3.0-or-later
// What a scan measures: views, each a table angle, a slide height and a raster of beams. Read from JSON
// (README.md says the keys) or laid out by default_plan.hpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/base/result.hpp"

namespace tetragauge {

// In the aim plane: through the point the head is aimed at, square to the beam at rest. y is the machine's y,
// up is the plane's other direction (35 degrees off the vertical). mm from the point aimed at.
struct RasterWindow {
  double y_min_mm = -72, y_max_mm = 72;
  double up_min_mm = -82, up_max_mm = 82;
};

struct PlannedView {
  double table_deg = 0;
  double slide_mm = 0;
  RasterWindow window;
  double pitch_mm = 1;  // between beams in the aim plane
  // With the laser on; half as many off before and after. 36 gives 300 points/s at 1 mm pitch.
  uint32_t samples = 36;
};

struct ScanPlan {
  std::vector<PlannedView> views;
};

// Errors name file and place, e.g. "plan.json: views[3].slide_mm = 340 is beyond ...".
Result<ScanPlan> read_plan(const std::filesystem::path& path);

// As read_plan() reads it: the same plan again, a view a line.
std::string plan_json(const ScanPlan& plan);

}  // namespace tetragauge
