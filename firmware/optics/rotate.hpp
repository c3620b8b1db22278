// SPDX-License-Identifier: Apache-2.0
// Rotation of a vector about a unit axis (Rodrigues), length, a check of limits.
#pragma once

#include "firmware/optics/scalar_math.hpp"
#include "firmware/optics/vector.hpp"

namespace tetragauge {

template <class Scalar>
constexpr Vector3<Scalar> rotated(const Vector3<Scalar>& v, const Vector3<Scalar>& axis,
                                  SinCos<Scalar> angle) {
  return v * angle.cos + cross(axis, v) * angle.sin + axis * (dot(axis, v) * (Scalar(1) - angle.cos));
}

template <class Scalar>
Scalar length(const Vector3<Scalar>& v) {
  return square_root(dot(v, v));
}

template <class Scalar>
Vector3<Scalar> normalized(const Vector3<Scalar>& v) {
  return v * (Scalar(1) / length(v));
}

template <class Scalar>
constexpr bool within(Scalar x, Scalar limit) {
  return -limit < x && x < limit;  // false for a NaN
}

}  // namespace tetragauge
