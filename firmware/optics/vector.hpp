// SPDX-License-Identifier: Apache-2.0
// Vectors and 3x3 matrices of the firmware, on any scalar (float, double).
#pragma once

namespace tetragauge {

template <class Scalar>
struct Vector3 {
  Scalar x{}, y{}, z{};

  constexpr Vector3 operator+(const Vector3& v) const { return {x + v.x, y + v.y, z + v.z}; }
  constexpr Vector3 operator-(const Vector3& v) const { return {x - v.x, y - v.y, z - v.z}; }
  constexpr Vector3 operator*(Scalar s) const { return {x * s, y * s, z * s}; }
  constexpr Vector3 operator-() const { return {-x, -y, -z}; }
  constexpr bool operator==(const Vector3&) const = default;
};

template <class Scalar>
constexpr Scalar dot(const Vector3<Scalar>& a, const Vector3<Scalar>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class Scalar>
constexpr Vector3<Scalar> cross(const Vector3<Scalar>& a, const Vector3<Scalar>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace tetragauge
