// SPDX-License-Identifier: GPL-3.0-or-later
// Each face's deviations against its tolerance.
#pragma once

#include "host/inspect/decide.hpp"
#include "host/solid/face_outline.hpp"

namespace tetragauge {

// Fills criteria, what decides, verdict and reason of the measured faces that have a tolerance.
void judge_faces(const Solid& model, const std::vector<FaceOutline>& outlines, const Tolerances& tolerances,
                 Inspection& inspection);

// One face by its own deviations. `poses_are_known`: false where the datums that should hold the part were
// not measured; what rests on the pose is then undecided.
void judge_face(FaceInspection& face, const FaceTolerance& tolerance, Rule rule, bool pose_is_known = true);

// What the verdict rests on is the criterion of the most severe verdict that uses most of its limit.
void conclude_criteria(FaceInspection& face);

// Two parallel faces whose own verdicts the pose leaves open, as nothing else holds the part along their
// normal: the distance between them needs no pose. If each would be within its limits even if all of the
// wrong distance were its own, both pass; if no placing of the part puts both within their limits, both fail,
// each named as a candidate.
void judge_distances(const Solid& model, const Tolerances& tolerances, std::vector<FaceInspection>& faces,
                     Rule rule);

}  // namespace tetragauge
