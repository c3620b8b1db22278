// SPDX-License-Identifier: GPL-3.0-or-later
// A scan plan for a part whose model and pose are known:
//
//   PartPlan plan = *plan_part(nominal_machine(), model, caster, T_part_model);
//   plan.scan                                  // views for run_scan(), plan_json() for a file
//   plan.faces[k].points, .why                 // what each face will get, and why one gets nothing
#pragma once

#include <string>
#include <vector>

#include "host/plan/choose_views.hpp"

namespace tetragauge {

struct PlanPartOptions {
  size_t points_per_face = 100;
  double max_incidence_deg = 65;  // of the beam, and of a camera
  double pitch_mm = 1;            // finer where a face needs it for its points
  uint32_t samples = PlannedView{}.samples;
};

struct FaceOutlook {
  int id = 0;
  size_t points = 0;                   // forecast within the largest incidence, by rays against the model
  double visible_share = 0;            // of its area, that any place sees within the largest incidence
  double flat_share = 0;               // that is seen flatter only; it is measured too, as well as it goes
  bool is_seen = false;                // any of it is, within the largest incidence
  double least_incidence_deg = 90;     // of any place that sees it; 90: none does
  Obstacle obstacle = Obstacle::none;  // of a face that is not seen; none: it is seen too flat only
  std::string why;                     // the same in words; empty when it is seen
};

struct PartPlan {
  ScanPlan scan;
  double time_s = 0;               // predicted, from the start of the scan to its end
  size_t places = 0;               // of the stage; a place may have several windows
  std::vector<FaceOutlook> faces;  // of the model, in its order
};

// `caster` is of the model, in its frame. `stance`: where the machine stands before. Errors (bad input): the
// part does not fit the machine; nothing of it can be seen.
Result<PartPlan> plan_part(const PlanningMachine& machine, const Solid& model, const RayCaster& caster,
                           const RigidTransform& T_part_model, const PlanPartOptions& options,
                           const MachineStance& stance);
inline Result<PartPlan> plan_part(const PlanningMachine& machine, const Solid& model, const RayCaster& caster,
                                  const RigidTransform& T_part_model, const PlanPartOptions& options = {}) {
  return plan_part(machine, model, caster, T_part_model, options, homed_stance(machine));
}

}  // namespace tetragauge
