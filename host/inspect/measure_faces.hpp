// SPDX-License-Identifier: GPL-3.0-or-later
// Every model face in turn: its raw points and its deviations; and what was measured beside the model.
#pragma once

#include "host/inspect/join_set_ups.hpp"
#include "host/inspect/part_pose.hpp"
#include "host/solid/face_outline.hpp"

namespace tetragauge {

struct MeasuredPart {
  std::vector<FaceInspection> faces;       // by model id; a verdict only where there was nothing to measure
  std::vector<int> missing;                // model ids that rays prove absent
  std::vector<std::vector<double>> share;  // per face that of each set-up in its points
  std::vector<float> point_deviation_mm;   // per raw point
  std::vector<int> point_face;             // per raw point its model id, 0: none
};

MeasuredPart measure_faces(const JoinedScan& joined, const Solid& model, const RayCaster& caster,
                           const std::vector<FaceOutline>& outlines, const PartPose& pose,
                           const Tolerances& tolerances);

// Measured faces that no model face explains (a boss, a chamfer, the floor of a pocket; no strip of a curved
// face that lies where that one was measured, be it out of place); out of tolerance
// where most of its points lie off the surface that their ray should have met, on either side, by more than
// the limit there and three sigma.
std::vector<ExtraFace> extra_faces(const JoinedScan& joined, const Solid& model,
                                   const std::vector<SetUp>& set_ups,
                                   const std::vector<FaceInspection>& faces, const Tolerances& tolerances);

}  // namespace tetragauge
