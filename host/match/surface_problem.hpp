// SPDX-License-Identifier: GPL-3.0-or-later
// A scan and a model's surface, thinned and indexed so that a pose is tried in microseconds.
#pragma once

#include <vector>

#include "host/match/nearest_sample.hpp"
#include "host/scan/scan.hpp"
#include "host/solid/ray_caster.hpp"
#include "host/solid/shadow_caster.hpp"

namespace tetragauge {

struct RayPoint {
  Vec3 point_mm = Vec3::Zero();  // part frame
  Vec3 towards = Vec3::Zero();   // unit, back to the ray's origin, part frame
  double range_mm = 0;           // to it
  double sigma_mm = 0;           // along the ray
};

struct SurfaceProblem {
  const std::vector<Face>& faces;  // the model's
  const RayCaster& caster;
  ShadowCaster shadows;
  NearestSample model;           // model frame, by side
  NearestSample scan;            // part frame; normals are zero
  std::vector<RayPoint> points;  // any first part is spread over the whole scan
  std::vector<Vec3> origins;     // of the rays, part frame: a few that stand for all
  double size_mm = 0;            // diagonal of the model's box
  Vec3 pivot_mm = Vec3::Zero();  // model frame
  double model_spacing_mm = 0, scan_spacing_mm = 0;
};

SurfaceProblem surface_problem(const Solid& model, const RayCaster& caster, const Scan& scan);

// A model sample that the rays' origins could see in a pose, and how squarely: 1 for a ray along the normal.
struct VisibleSample {
  const SurfaceSample* sample = nullptr;
  double cosine = 0;
};

// Of the first `count` samples. Flatter than 75 degrees counts as unseen: few sensors give a point there.
std::vector<VisibleSample> visible_samples(const SurfaceProblem& problem, const RigidTransform& T_model_part,
                                           size_t count);

}  // namespace tetragauge
