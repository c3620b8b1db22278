// SPDX-License-Identifier: GPL-3.0-or-later
// Steps 5 to 8 of the way of one point (DESIGN section 1): scan and model in, verdict out.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/base/result.hpp"
#include "host/base/stage_timer.hpp"
#include "host/inspect/tolerances.hpp"
#include "host/match/match.hpp"

namespace tetragauge {

// Order of severity over the faces of a part: fail > undecided > not_measured > pass.
enum class Verdict { pass, fail, undecided, not_measured, skipped, none };
std::string_view verdict_name(Verdict verdict);

struct FaceInspection {
  int model_id = 0, measured_id = 0;  // measured_id 0: no measured face
  bool measured = false;
  size_t points_used = 0, points_rejected = 0;
  double measured_area_mm2 = 0, coverage = 0;
  double offset_mm = 0, tilt_rad = 0,
         form_mm = 0;  // offset at the model face's centroid, + = excess material
  double U_offset_mm = 0, U_tilt_rad = 0, U_form_mm = 0;  // k = 2
  double profile_mm = 0,
         U_profile_mm = 0;  // largest |deviation| of offset, tilt over the face and form together
  double u_offset_own_mm =
      0;  // standard uncertainty of offset_mm without the pose's: of this face's points and the machine
  int candidate_with = 0;  // model id of the face that may as well be the one out of place; 0: none
  double rms_mm = 0;       // residual of the points across the fitted surface
  Verdict verdict = Verdict::none;
  // What the verdict rests on: the criterion ("profile", "offset", "flatness") nearest to or farthest beyond
  // its limit.
  std::string criterion;
  double deviation_mm = 0, U_mm = 0, limit_mm = 0;
  std::string reason;  // in words, e.g. "not seen: 3 points", "rays prove it absent"
};

// A place in the middle of a model face that the rays prove empty, or filled where the model has air.
struct MaterialFault {
  bool missing = false;          // else in excess
  int face = 0;                  // model id of the face there
  Vec3 point_mm = Vec3::Zero();  // model frame: the middle of it on that face
  size_t rays = 0;               // that prove it
  double depth_mm = 0;           // their median distance from the surface they should have met; 0: none
};

struct Inspection {
  Verdict verdict = Verdict::none;
  std::string rule;  // of the decision: guarded, iso14253-1:2017, simple
  Match match;
  std::vector<FaceInspection> faces;  // by model id, ascending
  std::vector<int> missing_faces;     // model ids that rays prove absent
  std::vector<int> extra_faces;       // measured ids that no model face explains
  std::vector<int>
      faces_out_of_model;  // those of them that lie off the model's surface beyond tolerance: a fail
  std::vector<MaterialFault> material_faults;  // by face: a fail
  double smallest_feature_mm =
      0;  // holes, bosses, notches under about this width can go unseen on the faces judged
  std::vector<float> point_deviation_mm;  // per raw point to the nearest model surface, + = excess material
  std::vector<int> point_face;            // per raw point its model id, 0: none
  StageTimer timing;
};

struct InspectOptions {
  enum class Rule { guarded, iso14253, simple } rule = Rule::guarded;
  ReconstructOptions reconstruct;
  FindFacesOptions faces;
  MatchOptions match;
};

// What every stage made, kept for the report.
struct InspectionRun {
  Reconstruction reconstruction;
  MeasuredFaces measured;
  Inspection inspection;
};

std::string_view rule_name(InspectOptions::Rule rule);

Result<InspectionRun> inspect(const Scan& scan, const Solid& model, const Tolerances& tolerances,
                              const InspectOptions& options = {});

}  // namespace tetragauge
