// SPDX-License-Identifier: GPL-3.0-or-later
// The boundary model: each face as a polygon whose edges are where planes meet and whose corners are where
// three do. The mesh says only which faces follow one another around a face.
#pragma once

#include <optional>
#include <vector>

#include "host/faces/assign_points.hpp"

namespace tetragauge {

// An edge from `from_mm` to the next one's, with the face `beyond` on its other side.
struct BoundaryEdge {
  Vec3 from_mm = Vec3::Zero();  // on the face's plane
  int32_t beyond = kNoRegion;   // index of a face; kNoRegion: the rim of what was measured
};

// Counter-clockwise seen from outside, a hole clockwise.
using BoundaryLoop = std::vector<BoundaryEdge>;

// Per face of `fitted` its loops.
std::vector<std::vector<BoundaryLoop>> trace_boundaries(const Reconstruction& reconstruction,
                                                        const SurfaceGraph& graph, const FittedFaces& fitted);

// The line where two planes meet; none for planes within about half a degree of one another.
struct MeetingLine {
  Vec3 point, direction;  // unit
  Vec3 foot(const Vec3& p) const { return point + direction * direction.dot(p - point); }
};
std::optional<MeetingLine> meeting_line(const PlaneFit& f, const PlaneFit& g);

}  // namespace tetragauge
