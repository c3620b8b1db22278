// SPDX-License-Identifier: GPL-3.0-or-later
// What is still to be measured of a plan that was interrupted, as a plan of its own.
//
// A beam's result depends on where the mirrors and the stage come from, if only by the last digit; so the
// rest begins with a lead-in: the one beam before it in the whole plan, measured again and dropped. Within a
// view it begins at an even row, for rasters run forth and back; beams that are there already are dropped.
#pragma once

#include <compare>
#include <optional>
#include <span>
#include <vector>

#include "protocol/machine.pb.h"

namespace tetragauge {

// A beam of the whole plan.
struct BeamPlace {
  uint32_t view = 0;
  uint32_t ray = 0;
  auto operator<=>(const BeamPlace&) const = default;
};

struct RestOfPlan {
  std::vector<tg_View> views;  // as the machine is to measure them; empty: nothing is left
  bool has_lead_in = false;    // views[0]
  BeamPlace from;              // the first beam that is missing
  uint32_t first_ray = 0;      // within the view `from` is in: where its rest begins
};

// `from`: ray may be the view's number of rays; then the next view is meant. `max_views`: the machine's.
RestOfPlan rest_of_plan(std::span<const tg_View> whole, BeamPlace from, uint32_t max_views);

// Where a beam of the rest belongs in the whole plan; nothing for the lead-in.
std::optional<BeamPlace> place_in_whole(const RestOfPlan& rest, BeamPlace in_rest);

}  // namespace tetragauge
