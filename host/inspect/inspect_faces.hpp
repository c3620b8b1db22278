// SPDX-License-Identifier: GPL-3.0-or-later
// Every model face in turn: its raw points, its deviations, its verdict.
#pragma once

#include "host/inspect/cast_scan.hpp"
#include "host/inspect/inspect.hpp"

namespace tetragauge {

// Fills faces, missing_faces, extra_faces, point_deviation_mm and point_face; reads `inspection.match`.
void inspect_faces(const Scan& scan, const Solid& model, const MeasuredFaces& measured, const CastScan& cast,
                   const Tolerances& tolerances, const InspectOptions& options, Inspection& inspection);

// Measured faces that no model face explains (a boss, a chamfer, the floor of a pocket) and most of whose
// points lie off the surface that their ray should have met, on either side, by more than the limit there and
// three sigma.
void judge_extra_faces(const Solid& model, const MeasuredFaces& measured, const CastScan& cast,
                       const Tolerances& tolerances, Inspection& inspection);

}  // namespace tetragauge
