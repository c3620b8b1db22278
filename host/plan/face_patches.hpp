// SPDX-License-Identifier: GPL-3.0-or-later
// The surface of a model as spots to look at: evenly spread over each face, and one just inside each corner,
// so that a window around a face's spots holds the whole face.
#pragma once

#include <vector>

#include "host/solid/ray_caster.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

struct Patch {
  Vec3 point_mm = Vec3::Zero();  // model frame
  Vec3 normal = Vec3::Zero();    // unit, out of the material
  double area_mm2 = 0;           // that it stands for; 0 of a corner
  double reach_mm = 0;           // its area may extend so far from it
  int face = 0;                  // index into Solid::faces()
};

// By face; the same for the same model.
std::vector<Patch> face_patches(const Solid& model, const RayCaster& caster);

}  // namespace tetragauge
