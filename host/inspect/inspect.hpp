// SPDX-License-Identifier: GPL-3.0-or-later
// Steps 5 to 8 of the way of one point (DESIGN section 1): scan and model in, verdict out.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "host/base/result.hpp"
#include "host/base/stage_timer.hpp"
#include "host/inspect/face_inspection.hpp"
#include "host/inspect/tolerances.hpp"
#include "host/match/match.hpp"

namespace tetragauge {

struct Inspection {
  Verdict verdict = Verdict::none;
  Rule rule = Rule::guarded;
  Alignment alignment;
  std::vector<FaceInspection> faces;  // by model id, ascending
  std::vector<FaceRelation> relations;
  std::vector<int> missing_faces;  // model ids that rays prove absent
  std::vector<ExtraFace> extra_faces;
  std::vector<MaterialFault> material_faults;  // by face: a fail
  double smallest_feature_mm =
      0;  // holes, bosses, notches under about this width can go unseen on the faces judged
  // Per raw point, the scans one after the other.
  std::vector<float> point_deviation_mm;  // to the nearest model surface, + = excess material
  std::vector<int> point_face;            // its model id, 0: none
  StageTimer timing;
};

struct InspectOptions {
  Rule rule = Rule::guarded;
  ReconstructOptions reconstruct;
  FindFacesOptions faces;
  MatchOptions match;
  std::function<void(const std::string&)> on_stage{};  // what begins, in words
};

// One scan of the part as it stood, on its own.
struct SetUp {
  Reconstruction reconstruction;
  MeasuredFaces measured;
  Match match;  // with datums: the pose that they give
};

// What every stage made, kept for the report.
struct InspectionRun {
  std::vector<SetUp> set_ups;  // one per scan
  Inspection inspection;
};

// Several scans are of one part in several set-ups (turned over between them): each is matched to the model
// on its own, and they are judged together. Errors name the scan by its place in the list when there are
// several.
Result<InspectionRun> inspect(std::span<const Scan> scans, const Solid& model, const Tolerances& tolerances,
                              const InspectOptions& options = {});

inline Result<InspectionRun> inspect(const Scan& scan, const Solid& model, const Tolerances& tolerances,
                                     const InspectOptions& options = {}) {
  return inspect(std::span(&scan, 1), model, tolerances, options);
}

}  // namespace tetragauge
