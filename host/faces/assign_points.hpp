// SPDX-License-Identifier: GPL-3.0-or-later
// Raw points to faces, and faces to their raw points, in turn until nothing changes.
//
// Near an edge the ray decides, not the nearest plane: where the ray meets the plane of a face does not
// depend on the noise along the ray, so that choosing by it cuts neither face's noise on one side and biases
// neither fit. Points closer to an edge than a band belong to no face, because a spot of finite size sees
// both.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/faces/grow_regions.hpp"
#include "host/geometry/fit_plane.hpp"
#include "host/scan/scan.hpp"

namespace tetragauge {

struct FittedFaces {
  std::vector<PlaneFit> fits;        // outward
  std::vector<int32_t> point_face;   // per raw point the face it was fitted to, kNoRegion: none
  std::vector<int32_t> point_side;   // the same, or the face in whose band at an edge it lies
  std::vector<int32_t> vertex_face;  // per vertex
};

// At most `rounds` turns. Faces that lose all but fewer than `min_points` points (those in their bands among
// them) are dropped.
FittedFaces assign_points(const Scan& scan, const Reconstruction& reconstruction, const SurfaceGraph& graph,
                          Regions regions, size_t min_points, int rounds);

// The plane through these raw points, weighted by 1 / sigma^2 across a plane of about this (outward) normal.
std::optional<PlaneFit> fit_members(const Scan& scan, const std::vector<double>& sigma_mm,
                                    const std::vector<uint32_t>& members, const Vec3& normal);

}  // namespace tetragauge
