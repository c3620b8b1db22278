// SPDX-License-Identifier: GPL-3.0-or-later
// What could be measured from where: every patch of the part looked at from every place of the stage that is
// worth trying.
#pragma once

#include <span>
#include <vector>

#include "host/plan/face_patches.hpp"
#include "host/plan/head_over_part.hpp"
#include "host/plan/machine_time.hpp"

namespace tetragauge {

// A patch that can be measured from a place: as asked, or, if no place can do that, flatter.
struct PatchSight {
  uint32_t patch = 0;
  float y_mm = 0, up_mm = 0;  // in the aim plane
  float cosine = 0;           // of the beam's incidence
  uint8_t cameras = 0;
};

struct CandidateView {
  StagePlace place;
  std::vector<PatchSight> sights;
};

// The best that any place can do for a patch.
struct PatchOutlook {
  Obstacle obstacle = Obstacle::turned_away;  // the last one that is left
  bool is_seen_well = false;                  // none is left, and within the largest incidence
  bool is_seen_flat = false;                  // not that, but within kFlat_rad
  double least_incidence_rad = 10;            // of what is seen, the flatter of beam and camera
};

struct SightSurvey {
  std::vector<CandidateView> candidates;  // by slide height, then by table angle
  std::vector<PatchOutlook> outlooks;     // of each patch
};

// A patch that no place sees as asked is measured flatter rather than not at all, up to here.
inline constexpr double kFlat_rad = 1.396;  // 80 degrees

// Places of the stage from which something of a part between these heights can be seen; part frame, by slide
// height, then by table angle.
std::vector<StagePlace> places_worth_trying(const PlanningMachine& machine, double low_mm, double high_mm);

SightSurvey survey_sights(const PlanningMachine& machine, const RayCaster& caster,
                          const RigidTransform& T_part_model, std::span<const Patch> patches,
                          double max_incidence_rad);

}  // namespace tetragauge
