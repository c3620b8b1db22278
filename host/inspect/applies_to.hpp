// SPDX-License-Identifier: GPL-3.0-or-later
// Which tolerance means something on which face. Each function says in words why not; "" where it does.
#pragma once

#include <string>
#include <string_view>

#include "host/inspect/tolerances.hpp"

namespace tetragauge {

std::string why_no_radius(const Face& face);

// `key` is one of kDatumLimitKeys.
std::string why_not_to_datum(std::string_view key, const Face& face, const Datum& datum);

// Nominally parallel, or at a right angle: within a milliradian, for meshes round their normals.
bool is_parallel(const Vec3& a, const Vec3& b);
bool is_perpendicular(const Vec3& a, const Vec3& b);

// Whether the face has an axis that can be measured and held against a datum.
bool has_axis(const Face& face);

}  // namespace tetragauge
