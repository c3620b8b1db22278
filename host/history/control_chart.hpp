// SPDX-License-Identifier: GPL-3.0-or-later
// A chart of individual values in the order of the parts: is the process what it was?
//
// Centre line: the mean. sigma: mean moving range of two / 1.128 (d2 for n = 2; Montgomery, Statistical
// Quality Control, chapter on individual measurements), so that a slow drift does not widen its own limits.
// Rules of the Western Electric Statistical Quality Control Handbook (1956), each on one side of the centre:
// 1: a point beyond 3 sigma; 2: two of three beyond 2 sigma; 3: four of five beyond 1 sigma; 4: eight in a
// row.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tetragauge {

struct OutOfControl {
  size_t index = 0;  // of the value that completes the pattern
  int rule = 0;      // 1 .. 4, the lowest that applies there
};

struct ControlChart {
  double centre = 0, sigma = 0;  // sigma 0: fewer than two values, or all equal
  std::vector<OutOfControl> signals;
};

ControlChart control_chart(std::span<const double> values);

}  // namespace tetragauge
