// SPDX-License-Identifier: GPL-3.0-or-later
// Parts for the benchmarks of the main job on the emulated machine, as .csg text: each as drawn, and as made
// with one face out of place.
#pragma once

#include <string>
#include <vector>

namespace tetragauge::bench {

struct MachinePart {
  std::string name;
  std::string good, bad;        // .csg
  std::string place;            // RX,RY,RZ,TX,TY,TZ on the table
  double bad_normal[3], bad_d;  // of the model's face that the bad one has 0.4 mm out
  bool has_slots = false;       // re-entrant corners, slots
};

const std::vector<MachinePart>& machine_parts();

}  // namespace tetragauge::bench
