// SPDX-License-Identifier: GPL-3.0-or-later
// For each place that the machine looked from a picture of the errors of range: measured less the model's
// along each ray, as in Henry's method of the thesis. A part in the wrong pose, a missing piece, a moved face
// show at a glance.
#pragma once

#include <limits>
#include <vector>

#include "host/report/report.hpp"

namespace tetragauge {

struct RangeImage {
  static constexpr float kNoRay = std::numeric_limits<float>::infinity();
  static constexpr float kNoModel = -kNoRay;  // a point where the model has nothing on its ray

  size_t set_up = 0;
  std::vector<uint32_t> views;  // ascending; all from one place
  bool is_perspective =
      true;          // pixels are even in the tangents of the beam's angles; else in mm across the beams
  double pixel = 0;  // side, in rad or mm
  size_t width = 0, height = 0;
  std::vector<float>
      beyond_mm;  // rows from the top; mean over the pixel's rays, + = behind the model's surface
  std::vector<uint16_t> face;  // model id that the pixel's first ray should have met; 0: none
  size_t rays = 0, on_model = 0;
  double mean_mm = 0, rms_mm = 0;  // over the rays on the model
};

// By scan, then view; places of fewer than 50 rays have no picture. In all at most `most_pixels`.
std::vector<RangeImage> range_images(const Report& report, size_t most_pixels = 100000);

}  // namespace tetragauge
