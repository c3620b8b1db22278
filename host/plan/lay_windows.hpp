// SPDX-License-Identifier: GPL-3.0-or-later
// Raster windows around spots seen from one place of the stage: as many rectangles as save time.
#pragma once

#include <span>
#include <vector>

#include "host/plan/machine_time.hpp"

namespace tetragauge {

// In the aim plane, as RasterWindow has it.
struct WindowSpot {
  double y_mm = 0, up_mm = 0;
  double reach_mm = 0;  // what belongs to it extends so far
};

// Where a beam with these mirror angles passes the aim plane; a raster's columns have one y, its rows one up.
WindowSpot window_spot(const HeadGeometry& head, int32_t a_urad, int32_t b_urad, double reach_mm);

struct RasterCost {
  double pitch_mm = 1;
  double ray_s = 0;     // of one ray
  double window_s = 0;  // of a window besides its rays
};
RasterCost raster_cost(const PlanningMachine& machine, double pitch_mm, uint32_t samples);

// One window around all of them, and the time it takes. Precondition of the former: not empty.
RasterWindow window_around(std::span<const WindowSpot> spots, const RasterCost& cost);
double time_of_window_s(std::span<const WindowSpot> spots, const RasterCost& cost);

struct WindowLayout {
  std::vector<RasterWindow> windows;
  double time_s = 0;
};
// Cut in two, and each half again, wherever that is quicker than one window.
WindowLayout lay_windows(std::vector<WindowSpot> spots, const RasterCost& cost);

}  // namespace tetragauge
