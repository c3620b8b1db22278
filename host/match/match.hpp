// SPDX-License-Identifier: GPL-3.0-or-later
// Measured faces against the faces of the solid model, with no initial pose (DESIGN section 5, "Match").
#pragma once

#include <string>
#include <vector>

#include "host/base/result.hpp"
#include "host/faces/find_faces.hpp"
#include "host/geometry/face.hpp"
#include "host/geometry/rigid_transform.hpp"
#include "host/scan/scan.hpp"
#include "host/solid/ray_caster.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

// One model face and one measured face.
struct FaceIds {
  int model = 0, measured = 0;
  auto operator<=>(const FaceIds&) const = default;
};

// What a person knows better than the search: pairs that must be, and pairs that must not be.
struct PairRules {
  std::vector<FaceIds> fixed, forbidden;
  std::string file;  // that they were read from: "fix" and "forbid" in errors
  bool empty() const { return fixed.empty() && forbidden.empty(); }
};

struct MatchOptions {
  bool is_unsigned = false;  // normals do not tell the side of the material
  double max_offset_mm = 0;  // farther from its place a face is not that face; 0: 1.5 % of the part's size
  double max_angle_rad = 0;  // the same for its direction; 0: 3.5 degrees
  PairRules rules;
};

struct FacePair {
  int model = 0, measured = 0;  // ids
  double offset_mm = 0;         // measured minus model, at the model face's centroid, + = excess material
  double angle_rad = 0;
  bool used_in_pose = true;  // false: out of place or tilted, so the pose was fitted without it
};

struct FreeDirection {
  enum class Kind { translation, rotation } kind = Kind::translation;
  Vec3 axis = Vec3::Zero();      // unit, model frame
  Vec3 point_mm = Vec3::Zero();  // on the axis of a rotation, model frame
};

struct EquivalentPose {
  RigidTransform T_model_part;
  std::string why;
  std::vector<FreeDirection> undetermined;  // it may rest on other faces than the chosen pose
};

// A pose that fits all but a few faces, and what rules it out.
struct RuledOutPose {
  RigidTransform T_model_part;
  std::vector<int> model_faces;  // that decided, ascending
  std::string why;
};

// Faces that fit one another but not the rest: the right shape in the wrong place.
struct MisplacedFeature {
  std::vector<FaceIds> pairs;               // ascending
  RigidTransform T_model_part;              // of this feature alone
  Vec3 shift_mm = Vec3::Zero();             // of its middle from where it should be, model frame
  double turn_rad = 0;                      // from how it should stand
  std::vector<FreeDirection> undetermined;  // in which its own faces do not say where it is
};

// What the pose rests on: planes where they determine it, otherwise all points against the model's surface.
enum class MatchedBy { planes, surface };

// How the scan's points lie about the surface, in a pose that they found.
struct SurfaceFit {
  std::string why;        // not by planes
  double scatter_mm = 0;  // across the surface, standard deviation from the median of the absolute values
  double explained = 0;   // share of the points within three of it, 0 to 1
};

struct Match {
  MatchedBy found_by = MatchedBy::planes;
  SurfaceFit surface_fit;       // found by the surface only
  RigidTransform T_model_part;  // p_model = T_model_part * p_part
  Mat6 covariance =
      Mat6::Zero();  // left perturbation rx ry rz tx ty tz about the part's centroid, rad and mm
  Vec3 centroid_mm = Vec3::Zero();  // the part's centroid, model frame: the pivot of the covariance
  double rms_mm = 0;                // across the faces the pose was fitted to
  std::vector<FacePair> pairs;      // ascending model id
  std::vector<int> unmatched_model, unmatched_measured;  // ids, ascending
  std::vector<EquivalentPose> equivalents;
  std::vector<RuledOutPose> ruled_out;  // of a near-symmetric part, the nearest first
  std::vector<FreeDirection> undetermined;
  std::vector<MisplacedFeature> misplaced;
  double max_offset_mm = 0;   // the gate used: a face farther from its place was not taken for that face
  size_t poses_compared = 0;  // full poses (rotation and translation) that were scored
};

// Lists alone: no rays, no raw points. Works on model lists read from .hsp too.
// Error (undecided): no pose explains the faces.
Result<Match> match_face_lists(const FaceList& model, const FaceList& measured,
                               const MatchOptions& options = {});

// The whole: poses from the lists, free-space violation along the scan's rays, refinement on raw points
// without faces that are out of place. Where the planes give no pose, leave directions free or explain too
// little of the scan, the raw points are matched to the model's surface, if that says more.
Result<Match> match_scan(const Solid& model, const RayCaster& caster, const Scan& scan,
                         const MeasuredFaces& measured, const MatchOptions& options = {});

}  // namespace tetragauge
