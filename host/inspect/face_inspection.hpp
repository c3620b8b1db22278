// SPDX-License-Identifier: GPL-3.0-or-later
// What is found out about one face of the model, and about the part as a whole.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/geometry/face.hpp"
#include "host/geometry/rigid_transform.hpp"

namespace tetragauge {

// Order of severity over the faces of a part: fail > undecided > not_measured > pass.
enum class Verdict { pass, fail, undecided, not_measured, skipped, none };
std::string_view verdict_name(Verdict verdict);

enum class Rule { guarded, iso14253, simple };
std::string_view rule_name(Rule rule);  // guarded, iso14253-1:2017, simple

// One deviation against its limit; mm, or mrad for `angularity`.
struct Criterion {
  std::string name;  // profile, offset, radius, flatness, position, ..., distance
  double deviation = 0, U = 0, limit = 0;
  Verdict verdict = Verdict::none;
  std::string datum;  // the one it is held against; "": none

  bool is_angle() const { return name == "angularity"; }
};

// A plane as its points lie, model frame.
struct PlaneAsMeasured {
  Vec3 normal = Vec3::Zero();    // unit, out of the material
  Vec3 point_mm = Vec3::Zero();  // centroid of the points, on the plane
  PlaneCovariance covariance;    // at point_mm, of the face's own points and the machine, not of the pose
};

// A curved face as its points lie: the motion and the growth that take the model's surface there. Along
// directions that the surface does not feel (a cylinder's axis) all is 0.
struct CurveAsMeasured {
  using Vec7 = Eigen::Matrix<double, 7, 1>;
  using Mat7 = Eigen::Matrix<double, 7, 7>;
  Vec3 pivot_mm = Vec3::Zero();  // the model face's centre or a point of its axis amid its points
  Vec7 motion = Vec7::Zero();  // turn rx ry rz [rad], shift tx ty tz [mm] of the pivot, growth outwards [mm]
  Mat7 covariance = Mat7::Zero();  // of the face's own points and the machine, not of the pose
};

struct FaceInspection {
  int model_id = 0, measured_id = 0;  // measured_id 0: no measured face
  bool measured = false;
  size_t points_used = 0, points_rejected = 0;
  double measured_area_mm2 = 0, coverage = 0;
  double offset_mm = 0, tilt_rad = 0,
         form_mm = 0;  // offset at the model face's centroid, + = excess material
  double U_offset_mm = 0, U_tilt_rad = 0, U_form_mm = 0;  // k = 2
  double profile_mm = 0,
         U_profile_mm = 0;          // largest |deviation| of offset, tilt over the face and form together
  std::optional<double> radius_mm;  // cylinder, sphere: measured less nominal
  double U_radius_mm = 0;
  std::optional<double>
      position_mm;  // cylinder: largest shift of its axis within the face; sphere: of its centre
  double U_position_mm = 0;
  double u_offset_own_mm =
      0;  // standard uncertainty of offset_mm without the pose's: of this face's points and the machine
  std::optional<PlaneAsMeasured> plane;
  std::optional<CurveAsMeasured> curve;

  // Roughness: what is left of the points across the fitted surface, and what the machine alone would leave.
  double rms_mm = 0, peak_to_valley_mm = 0, machine_sigma_mm = 0;
  // Point by point against the model's surface.
  double point_mean_mm = 0, point_rms_mm = 0, point_p95_mm = 0, point_max_mm = 0;

  int candidate_with = 0;  // model id of the face that may as well be the one out of place; 0: none
  Verdict verdict = Verdict::none;
  std::vector<Criterion> criteria;      // all that were judged, in the order of the tolerance file's keys
  std::optional<Criterion> decided_by;  // the one of them nearest to or farthest beyond its limit
  std::string reason;                   // in words, e.g. "not seen: 3 points", "rays prove it absent"
};

// How two plane faces lie to each other, whatever the pose.
struct FaceRelation {
  int first = 0, second = 0;                          // model ids
  bool are_neighbours = false, are_parallel = false;  // parallel: opposed normals included
  // Between their normals.
  double nominal_angle_rad = 0, angle_deviation_rad = 0, U_angle_rad = 0;
  // Parallel ones: amid their centroids, + = farther apart.
  double nominal_distance_mm = 0, distance_deviation_mm = 0, U_distance_mm = 0;
};

// A measured face that no model face explains.
struct ExtraFace {
  size_t set_up = 0;              // index of the scan
  int measured_id = 0;            // there
  Face face;                      // model frame
  bool out_of_tolerance = false;  // off the model's surface beyond tolerance: a fail
};

// A place in the middle of a model face that the rays prove empty, or filled where the model has air.
struct MaterialFault {
  bool missing = false;          // else in excess
  int face = 0;                  // model id of the face there
  Vec3 point_mm = Vec3::Zero();  // model frame: the middle of it on that face
  size_t rays = 0;               // that prove it
  double depth_mm = 0;           // their median distance from the surface they should have met; 0: none
};

// What holds the part in the model's frame.
struct Alignment {
  struct Held {
    std::string datum;
    int face = 0;
    int rotations = 0, translations = 0;  // that this datum fixes
  };
  std::vector<Held> datums;  // in their order; empty: best fit
  std::string
      problem;  // datums are wanted, but this one was not measured: nothing that rests on them is decided
};

}  // namespace tetragauge
