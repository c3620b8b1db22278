// SPDX-License-Identifier: GPL-3.0-or-later
// The plan for a part that stands on the table nobody knows how: a quick coarse scan, matched against the
// model, gives its pose, and the pose a plan.
#pragma once

#include <string>

#include "host/inspect/inspect.hpp"
#include "host/plan/plan_part.hpp"
#include "host/session/default_plan.hpp"

namespace tetragauge {

struct SurveyedPlan {
  ScanPlan scan;
  std::string how;       // how it came about, in a sentence
  double machine_s = 0;  // that finding it took
};

// Where the pose cannot be told it is the plan all round the part (default_plan.hpp), and `how` says why.
Result<SurveyedPlan> plan_by_survey(Link& link, const PlanningMachine& machine, const Solid& model,
                                    const RayCaster& caster, const InspectOptions& inspect,
                                    const PlanPartOptions& options, const ScanOptions& scan);

// Whether a part in pose b stands where one in pose a does: a symmetry of the model.
bool stands_alike(const Solid& model, const RayCaster& caster, const RigidTransform& T_model_part_a,
                  const RigidTransform& T_model_part_b);

}  // namespace tetragauge
