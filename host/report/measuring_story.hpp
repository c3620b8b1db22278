// SPDX-License-Identifier: GPL-3.0-or-later
// How a part was measured beyond its first scan, for the report: what each round of re-measurement changed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tetragauge {

struct Doubts {
  size_t doubtful = 0;  // tetrahedra
  double doubtful_mm3 = 0;
  size_t resolvable = 0;  // of them, those that a legal ray could still decide
  double resolvable_mm3 = 0;
  size_t undecided = 0, not_measured = 0;  // faces
};

struct MeasuringRound {
  size_t rays = 0, views = 0, points = 0;  // single directions, rasters, and what they gave together
  Doubts before, after;
  double machine_s = 0;  // that it takes by the machine's own rules: the same for equal runs
};

struct MeasuringStory {
  std::string plan;  // where the views of the first scan came from
  std::vector<MeasuringRound> rounds;
  std::string end;           // why there was no further one
  std::string interruption;  // what broke a round off; empty: nothing
};

}  // namespace tetragauge
