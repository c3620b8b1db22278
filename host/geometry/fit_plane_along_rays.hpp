// SPDX-License-Identifier: GPL-3.0-or-later
// The plane through points that each err along their own ray: minimises sum w_i (n . p_i - d)^2 with each
// point held at the place where its ray meets the plane. A total fit takes the part of the error along the
// plane for place; on a face that is hardly wider than that the plane leans towards the rays (errors in both
// variables: Fuller, Measurement Error Models, 1987, section 1.1).
#pragma once

#include <span>

#include "host/geometry/fit_plane.hpp"

namespace tetragauge {

// One unit direction per point, from the sensor to it; `weights` 1/sigma^2 with sigma across the plane.
// `near`: a normal within some 30 degrees of the plane's; the result's has its sign. nullopt as for
// fit_plane, and where there is no plane near it.
std::optional<PlaneFit> fit_plane_along_rays(std::span<const Vec3> points, std::span<const Vec3> directions,
                                             std::span<const double> weights, const Vec3& near);

// Where a point that errs along `direction` belongs on the plane through `on_plane`.
Vec3 meet_plane(const Vec3& point, const Vec3& direction, const Vec3& normal, const Vec3& on_plane);

}  // namespace tetragauge
