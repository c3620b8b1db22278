// SPDX-License-Identifier: GPL-3.0-or-later
// From deviations with their uncertainty to a verdict.
#pragma once

#include "host/inspect/inspect.hpp"

namespace tetragauge {

// U at k = 2. guarded: pass only if |deviation| + U <= limit, fail only if |deviation| - U > limit. iso14253:
// the same with ISO 14253-1:2017's guard band for 95 % conformity, 1.65 standard uncertainties. simple: U is
// ignored.
Verdict decide(double deviation, double U, double limit, Rule rule);

// The more severe of two: fail > undecided > not_measured > pass > skipped, none.
Verdict worse(Verdict a, Verdict b);

// Over the faces that have a tolerance and are not skipped.
Verdict judge_part(const Inspection& inspection, const Solid& model, const Tolerances& tolerances);

}  // namespace tetragauge
