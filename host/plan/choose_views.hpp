// SPDX-License-Identifier: GPL-3.0-or-later
// From all places to the few that are needed: every patch that can be seen is in one of them, and the time
// they take together is short.
#pragma once

#include <span>
#include <vector>

#include "host/plan/lay_windows.hpp"
#include "host/plan/survey_sights.hpp"

namespace tetragauge {

struct ChosenView {
  size_t candidate = 0;          // of the survey
  std::vector<uint32_t> sights;  // of that candidate: the patches it is to measure, ascending
};

struct ViewCost {
  RasterCost raster;
  double place_s = 0;  // of going to another place of the stage
};
ViewCost view_cost(const PlanningMachine& machine, double pitch_mm, uint32_t samples);

// What they are to measure, as spots in the aim plane.
std::vector<WindowSpot> window_spots(const CandidateView& view, std::span<const uint32_t> sights,
                                     std::span<const Patch> patches);

// Greedy set cover by patches per second (Chvatal, Math. Oper. Res. 4 (1979) 233), then views dropped whose
// patches others can take, and each moved to a neighbouring place that sees the same in less time. `wanted`:
// of each patch, whether it is to be covered; what no place sees is left out.
std::vector<ChosenView> choose_views(const SightSurvey& survey, std::span<const Patch> patches,
                                     const std::vector<bool>& wanted, const ViewCost& cost);

}  // namespace tetragauge
