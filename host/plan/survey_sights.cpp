// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/survey_sights.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "host/plan/lay_windows.hpp"
#include "host/session/plan_limits.hpp"

namespace tetragauge {
namespace {

// Sights change slowly with the place: a tenth of the +-59 degrees that a wall is seen over, and a tenth of
// the 35 degrees by which the slide can change how steeply the beam comes down.
constexpr double kTableStep_deg = 10, kSlideStep_mm = 25;

}  // namespace

std::vector<StagePlace> places_worth_trying(const PlanningMachine& machine, double low_mm, double high_mm) {
  const tg_StageConfig& stage = machine.config.stage;
  const double slide_low = std::max(kSlideLowest_mm, 1e3 * stage.slide.min_steps / stage.slide_steps_per_m);
  const double slide_high = std::min(kSlideHighest_mm, 1e3 * stage.slide.max_steps / stage.slide_steps_per_m);
  // Part of it must stand where the beam goes: some 130 mm above and below the point aimed at.
  constexpr double kReach_mm = 130;
  const double aim = machine.head.aim_mm.z();
  std::vector<StagePlace> places;
  // From the middle of the part's height outwards in whole steps, so that the plain view is among them.
  const double middle = std::clamp(aim - 0.5 * (low_mm + high_mm), slide_low, slide_high);
  const auto steps_down = static_cast<int>((middle - slide_low) / kSlideStep_mm);
  const auto steps_up = static_cast<int>((slide_high - middle) / kSlideStep_mm);
  for (int k = -steps_down; k <= steps_up; ++k) {
    const double slide = std::round(10 * (middle + k * kSlideStep_mm)) / 10;
    if (high_mm + slide < aim - kReach_mm || low_mm + slide > aim + kReach_mm) continue;
    for (double table = -180; table < 180; table += kTableStep_deg) {
      const int64_t steps = table_steps(machine.config, static_cast<int32_t>(std::lround(1e6 * table)));
      if (steps >= stage.table.min_steps && steps <= stage.table.max_steps) places.push_back({table, slide});
    }
  }
  return places;
}

SightSurvey survey_sights(const PlanningMachine& machine, const RayCaster& caster,
                          const RigidTransform& T_part_model, std::span<const Patch> patches,
                          double max_incidence_rad) {
  SightSurvey survey;
  double low_mm = 1e9, high_mm = -1e9;
  for (const Patch& patch : patches) {
    const double z = (T_part_model * patch.point_mm).z();
    low_mm = std::min(low_mm, z);
    high_mm = std::max(high_mm, z);
  }
  for (const StagePlace& place : places_worth_trying(machine, low_mm, high_mm))
    survey.candidates.push_back({place, {}});
  std::vector<std::vector<PatchOutlook>> outlooks(survey.candidates.size());
  // Each candidate writes its own slots: the result does not depend on the threads.
  tbb::parallel_for(size_t{0}, survey.candidates.size(), [&](size_t c) {
    CandidateView& view = survey.candidates[c];
    const HeadOverPart head(machine, T_part_model, view.place);
    outlooks[c].resize(patches.size());
    for (uint32_t k = 0; k < patches.size(); ++k) {
      const SpotSight sight = head.look_at(caster, patches[k].point_mm, patches[k].normal);
      PatchOutlook& outlook = outlooks[c][k];
      outlook.obstacle = sight.obstacle;
      if (sight.obstacle != Obstacle::none) continue;
      const WindowSpot spot = window_spot(machine.head, sight.a_urad, sight.b_urad, patches[k].reach_mm);
      if (std::max(std::abs(spot.y_mm), std::abs(spot.up_mm)) + spot.reach_mm > kWindowReach_mm) {
        outlook.obstacle = Obstacle::out_of_reach;
        continue;
      }
      outlook.least_incidence_rad = std::max(sight.beam_incidence_rad, sight.camera_incidence_rad);
      outlook.is_seen_well = sight.within(max_incidence_rad);
      outlook.is_seen_flat = sight.within(kFlat_rad);
      if (!outlook.is_seen_well && !outlook.is_seen_flat) continue;
      view.sights.push_back({k, static_cast<float>(spot.y_mm), static_cast<float>(spot.up_mm),
                             static_cast<float>(std::cos(sight.beam_incidence_rad)),
                             static_cast<uint8_t>(sight.cameras)});
    }
  });
  survey.outlooks.resize(patches.size());
  for (const std::vector<PatchOutlook>& from_here : outlooks) {
    for (size_t k = 0; k < patches.size(); ++k) {
      PatchOutlook& best = survey.outlooks[k];
      best.obstacle = std::max(best.obstacle, from_here[k].obstacle);
      best.is_seen_well = best.is_seen_well || from_here[k].is_seen_well;
      best.is_seen_flat = best.is_seen_flat || from_here[k].is_seen_flat;
      best.least_incidence_rad = std::min(best.least_incidence_rad, from_here[k].least_incidence_rad);
    }
  }
  for (PatchOutlook& outlook : survey.outlooks)
    outlook.is_seen_flat = outlook.is_seen_flat && !outlook.is_seen_well;
  for (size_t c = 0; c < survey.candidates.size(); ++c) {
    std::erase_if(survey.candidates[c].sights, [&](const PatchSight& sight) {
      return !outlooks[c][sight.patch].is_seen_well && !survey.outlooks[sight.patch].is_seen_flat;
    });
  }
  return survey;
}

}  // namespace tetragauge
