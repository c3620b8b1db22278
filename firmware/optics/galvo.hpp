// SPDX-License-Identifier: Apache-2.0
// The beam for two mirror angles, and the mirror angles for a point to aim at.
//
//   Beam<double> beam = beam_from_mirrors(geometry.galvo, a_rad, b_rad);
//   MirrorAngles<double> m = aim_mirrors(geometry.galvo, point);
#pragma once

#include "firmware/optics/geometry.hpp"
#include "firmware/optics/rotate.hpp"

namespace tetragauge {

template <class Scalar>
struct Beam {
  Vector3<Scalar> origin;     // on the last mirror
  Vector3<Scalar> direction;  // unit
};

template <class Scalar>
struct MirrorAngles {
  Scalar a_rad{}, b_rad{};  // mechanical, as commanded
  bool reached = false;
};

namespace detail {
template <class Scalar>
Beam<Scalar> reflected(const Beam<Scalar>& in, const Vector3<Scalar>& point, const Vector3<Scalar>& normal) {
  const Scalar along = dot(in.direction, normal);
  const Scalar range = dot(point - in.origin, normal) / along;
  return {in.origin + in.direction * range, in.direction - normal * (2 * along)};
}
}  // namespace detail

template <class Scalar>
Beam<Scalar> beam_from_mirrors(const GalvoGeometry<Scalar>& galvo, Scalar a_rad, Scalar b_rad) {
  const Scalar a_true = galvo.a_scale * a_rad + galvo.a_zero_rad;
  const Scalar b_true = galvo.b_scale * b_rad + galvo.b_zero_rad;
  const Vector3<Scalar> a_normal = rotated(galvo.a_normal, galvo.a_axis, sin_cos(a_true));
  const Vector3<Scalar> b_normal = rotated(galvo.b_normal, galvo.b_axis, sin_cos(b_true));
  const Beam<Scalar> laser{galvo.beam_point, galvo.beam_direction};
  return detail::reflected(detail::reflected(laser, galvo.a_point, a_normal), galvo.b_point, b_normal);
}

// Newton's method on the two components of the miss across the beam; derivatives by central differences of 10
// urad, which a smooth beam makes exact to 1e-9. Not reached: the point is behind the head or beyond +-0.6
// rad.
template <class Scalar>
MirrorAngles<Scalar> aim_mirrors(const GalvoGeometry<Scalar>& galvo, const Vector3<Scalar>& point) {
  const auto miss = [&](Scalar a, Scalar b) {
    const Beam<Scalar> beam = beam_from_mirrors(galvo, a, b);
    const Vector3<Scalar> to = point - beam.origin;
    const Scalar range = dot(to, beam.direction);
    return (beam.direction - to * (Scalar(1) / range));
  };
  MirrorAngles<Scalar> angles;
  const Scalar step = static_cast<Scalar>(1e-5);
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Vector3<Scalar> now = miss(angles.a_rad, angles.b_rad);
    const Vector3<Scalar> da =
        (miss(angles.a_rad + step, angles.b_rad) - miss(angles.a_rad - step, angles.b_rad)) *
        (Scalar(0.5) / step);
    const Vector3<Scalar> db =
        (miss(angles.a_rad, angles.b_rad + step) - miss(angles.a_rad, angles.b_rad - step)) *
        (Scalar(0.5) / step);
    // Least squares of 3 equations in 2 unknowns: the miss has no component along the beam to first order.
    const Scalar aa = dot(da, da), ab = dot(da, db), bb = dot(db, db);
    const Scalar det = aa * bb - ab * ab;
    if (!(det > 0)) return angles;
    const Scalar delta_a = (ab * dot(db, now) - bb * dot(da, now)) / det;
    const Scalar delta_b = (ab * dot(da, now) - aa * dot(db, now)) / det;
    angles.a_rad = angles.a_rad + delta_a;
    angles.b_rad = angles.b_rad + delta_b;
    const Scalar bound = static_cast<Scalar>(0.6);
    if (!within(angles.a_rad, bound) || !within(angles.b_rad, bound)) {
      return angles;
    }
    const Scalar small = static_cast<Scalar>(sizeof(Scalar) == 4 ? 1e-6 : 1e-12);
    if (within(delta_a, small) && within(delta_b, small)) {
      const Beam<Scalar> beam = beam_from_mirrors(galvo, angles.a_rad, angles.b_rad);
      angles.reached = dot(point - beam.origin, beam.direction) > 0;
      return angles;
    }
  }
  return angles;
}

// Mechanical mirror step for a spacing of pitch_mm across the beam at distance_mm: the beam turns twice as
// far.
template <class Scalar>
constexpr Scalar mirror_step_rad(Scalar pitch_mm, Scalar distance_mm) {
  return pitch_mm / (2 * distance_mm);
}

}  // namespace tetragauge
