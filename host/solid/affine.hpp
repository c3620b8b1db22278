// SPDX-License-Identifier: GPL-3.0-or-later
// The matrices of a .csg file: affine maps, and the ways they can be applied to exact surfaces.
#pragma once

#include <gp_Trsf.hxx>
#include <optional>

#include "host/geometry/vec.hpp"

namespace tetragauge {

struct Affine {
  Mat3 A = Mat3::Identity();
  Vec3 t = Vec3::Zero();  // mm

  Vec3 operator*(const Vec3& p) const { return A * p + t; }
  Affine operator*(const Affine& other) const { return {A * other.A, A * other.t + t}; }
};

// The rotation (or mirror) times one scale that a six-digit matrix was printed from; the matrix itself if it
// is something else or has its full digits.
Affine restore_digits(const Affine& printed);

// A motion, mirror and uniform scale as OpenCASCADE applies it exactly; nullopt if M is something else.
std::optional<gp_Trsf> similarity(const Affine& M);

// M = S * diag(1, 1, along_z) with a similarity S: round bodies about z stay round under it.
struct AxialScale {
  gp_Trsf S;
  double along_z = 1;
};
std::optional<AxialScale> axial_scale(const Affine& M);

}  // namespace tetragauge
