// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors and turns in words for people.
#pragma once

#include <string>

#include "host/geometry/rigid_transform.hpp"

namespace tetragauge {

// Of an axis and its opposite always the same one: its largest entry is positive; of entries that are nearly
// as large, the first.
Vec3 canonical_axis(const Vec3& axis);

std::string number_text(double value, int decimals);   // never -0.000
std::string vector_text(const Vec3& v, int decimals);  // "(0.000, -1.250, 3.000)"

// "turned by -90.0 degrees about (0.000, 0.000, 1.000)", the axis canonical; half a turn is 180.0, never
// -180.0.
std::string turn_text(const Mat3& R);

// The same of a motion that turns; of one that does not, "shifted by (3.0, 0.0, 0.0) mm".
std::string motion_text(const RigidTransform& motion);

}  // namespace tetragauge
