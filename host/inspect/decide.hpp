// SPDX-License-Identifier: GPL-3.0-or-later
// From deviations with their uncertainty to a verdict.
#pragma once

#include "host/inspect/inspect.hpp"

namespace tetragauge {

// U at k = 2. guarded: pass only if |deviation| + U <= limit, fail only if |deviation| - U > limit. iso14253:
// the same with ISO 14253-1:2017's guard band for 95 % conformity, 1.65 standard uncertainties. simple: U is
// ignored.
Verdict decide(double deviation_mm, double U_mm, double limit_mm, InspectOptions::Rule rule);

// The more severe of two: fail > undecided > not_measured > pass > skipped, none.
Verdict worse(Verdict a, Verdict b);

// Fills verdict, criterion and reason of a measured face from its deviations.
void judge_face(FaceInspection& face, const FaceTolerance& tolerance, InspectOptions::Rule rule);

// Two parallel faces whose own verdicts the pose leaves open, as nothing else holds the part along their
// normal: the distance between them needs no pose. If no placing of the part puts both within their limits,
// both fail, each named as a candidate.
void judge_distances(const Solid& model, const Tolerances& tolerances, std::vector<FaceInspection>& faces,
                     InspectOptions::Rule rule);

// Over the faces that have a tolerance and are not skipped.
Verdict judge_part(const Inspection& inspection, const Solid& model, const Tolerances& tolerances);

bool has_tolerance(const FaceTolerance& tolerance);

// The limit that a face's offset must keep to, mm: the tighter of profile and offset; 1e300 without either.
double offset_limit(const FaceTolerance& tolerance);

}  // namespace tetragauge
