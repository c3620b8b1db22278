// SPDX-License-Identifier: Apache-2.0
// Rotary table on a slide: p_machine = axis_point + slide * slide_direction + R(axis_direction, table)
// p_part.
#pragma once

#include "firmware/optics/geometry.hpp"
#include "firmware/optics/rotate.hpp"

namespace tetragauge {

template <class Scalar>
Vector3<Scalar> machine_from_part(const StageGeometry<Scalar>& stage, Scalar table_rad, Scalar slide_mm,
                                  const Vector3<Scalar>& p_part) {
  return stage.axis_point + stage.slide_direction * slide_mm +
         rotated(p_part, stage.axis_direction, sin_cos(table_rad));
}

template <class Scalar>
Vector3<Scalar> part_from_machine(const StageGeometry<Scalar>& stage, Scalar table_rad, Scalar slide_mm,
                                  const Vector3<Scalar>& p_machine) {
  return rotated(p_machine - stage.axis_point - stage.slide_direction * slide_mm, stage.axis_direction,
                 sin_cos(-table_rad));
}

template <class Scalar>
constexpr bool inside(const VolumeBox<Scalar>& box, const Vector3<Scalar>& p) {
  return p.x >= box.min.x && p.x <= box.max.x && p.y >= box.min.y && p.y <= box.max.y && p.z >= box.min.z &&
         p.z <= box.max.z;
}

}  // namespace tetragauge
