// SPDX-License-Identifier: GPL-3.0-or-later
// The pose that fits measured planes to model planes, without those that are out of place.
#pragma once

#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/match/plane_set.hpp"

namespace tetragauge {

// One measured plane on one model plane. The measured plane's offset, two tilts and their 3x3 covariance are
// all that its raw points say about the pose, so a fit to these is a fit to the raw points.
struct PlaneObservation {
  Vec3 model_normal = Vec3::Zero();
  double model_d_mm = 0;
  Vec3 point_mm = Vec3::Zero();  // measured, part frame, on the plane; the covariance holds there
  PlaneCovariance covariance;    // part frame; u x v is the measured normal out of the material
};

struct RefinedPose {
  RigidTransform T_model_part;
  Mat6 covariance = Mat6::Zero();  // left perturbation rx ry rz tx ty tz about the pivot
  std::vector<bool> used;          // per observation: false where it is out of place
  double rms_mm = 0;               // offsets of the used ones
  // How far faces deviate beyond their own uncertainty: one standard deviation, of offset and of tilt.
  double scatter_mm = 0, scatter_rad = 0;
};

// The scatter that is expected before the faces are seen. It counts as much as four of them would, less those
// that there are; 0 where the faces' own uncertainties are known.
struct ScatterPrior {
  double mm = 0, rad = 0;
};

// `size_mm` sets the floor of the scatter where the list has no uncertainty of its own.
RefinedPose refine_pose(const std::vector<PlaneObservation>& observations, const RigidTransform& start,
                        const Vec3& pivot_mm, double size_mm, const ScatterPrior& prior);

// Offset [mm], tilt about u, tilt about v [rad] of the observed plane against the model's, in pose T.
Vec3 plane_residual(const PlaneObservation& observation, const RigidTransform& T_model_part);

// Turns a measured plane's frame so that u x v is its normal, or the opposite one.
PlaneObservation observe(const MatchPlane& model, const MatchPlane& measured, bool flipped);

}  // namespace tetragauge
