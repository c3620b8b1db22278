// SPDX-License-Identifier: GPL-3.0-or-later
// Each measuring ray against the posed model: the model face it should have met, and how far its point lies
// from that face's analytic surface.
#pragma once

#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/scan/scan.hpp"
#include "host/solid/ray_caster.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

// Per raw point; all of the scan's size.
struct CastScan {
  std::vector<Vec3> points_mm;       // model frame
  std::vector<int> face;             // index into Solid::faces(), -1: the ray meets nothing
  std::vector<Vec3> hit_mm;          // where the ray meets the model, model frame
  std::vector<Vec3> origin_mm;       // of its ray, model frame
  std::vector<Vec3> direction;       // of its ray, unit; nil for a point at its ray's origin
  std::vector<double> deviation_mm;  // of the point to that face's surface, + = outside the material
  std::vector<double> sigma_mm;      // of the point across that surface
  std::vector<double> cosine;        // of the ray's incidence on that surface
  std::vector<double> beyond_mm;     // measured range less the model's: + = the point lies behind the surface
};

CastScan cast_scan(const Scan& scan, const Solid& model, const RayCaster& caster,
                   const RigidTransform& T_model_part);

}  // namespace tetragauge
