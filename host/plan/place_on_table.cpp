// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/place_on_table.hpp"

namespace tetragauge {

RigidTransform place_on_table(const Solid& model, const RigidTransform& place) {
  const Solid turned = transformed(model, {place.R, Vec3::Zero()});
  const Vec3 middle = 0.5 * (turned.box_min_mm + turned.box_max_mm);
  return {place.R, Vec3(-middle.x(), -middle.y(), -turned.box_min_mm.z()) + place.t};
}

}  // namespace tetragauge
