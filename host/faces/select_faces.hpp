// SPDX-License-Identifier: GPL-3.0-or-later
// Which of the fitted planes are real faces. Decided by statistics of the points, never by a fixed angle.
#pragma once

#include "host/faces/assign_points.hpp"

namespace tetragauge {

struct Selection {
  Regions regions;  // what is left, to be fitted again if anything changed
  bool changed = false;
  size_t false_chamfers = 0;
  std::vector<size_t> curved;  // faces dropped as pieces of a curved surface
};

// Unites neighbours on one plane; drops strips narrower than the spacing can resolve, false chamfers (all
// points explained by the neighbours' planes), and pieces cut out of a curved surface by the gate.
Selection select_faces(const Scan& scan, const Reconstruction& reconstruction, const SurfaceGraph& graph,
                       const FittedFaces& fitted);

// Share of a face's rim across which the surface goes on with a slope of less than a third (about 18
// degrees); the rim towards the face `but_to` is not counted.
double soft_rim_share(const Reconstruction& reconstruction, const SurfaceGraph& graph,
                      const FittedFaces& fitted, size_t face, int32_t but_to = kNoRegion);

// Beside a shallow crease a plane strip has up to half of its rim; a piece of a curve goes on at both sides.
constexpr double kGoesOnBothSides = 0.5;

// Faces of at least `min_points` points, those in their bands counted, and not too narrow to be told from the
// spread of an edge: ascending.
std::vector<size_t> reportable(const Scan& scan, const Reconstruction& reconstruction,
                               const FittedFaces& fitted, size_t min_points);

// One face per connected piece; pieces of fewer than `min_points` raw points are on no face. Pieces of fewer
// than `face_points` are joined over a single vertex: crumbs of a face hardly wider than two spacings.
FittedFaces split_unconnected(const Scan& scan, const Reconstruction& reconstruction,
                              const SurfaceGraph& graph, FittedFaces fitted, size_t min_points,
                              size_t face_points);

}  // namespace tetragauge
