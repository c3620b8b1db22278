// SPDX-License-Identifier: GPL-3.0-or-later
// Which of the fitted planes are real faces. Decided by statistics of the points, never by a fixed angle.
#pragma once

#include "host/faces/assign_points.hpp"

namespace tetragauge {

struct Selection {
  Regions regions;  // what is left, to be fitted again if anything changed
  bool changed = false;
  size_t false_chamfers = 0;
};

// Unites neighbours on one plane; drops strips narrower than the spacing can resolve, false chamfers (all
// points explained by the neighbours' planes), and pieces cut out of a curved surface by the gate.
Selection select_faces(const Scan& scan, const Reconstruction& reconstruction, const SurfaceGraph& graph,
                       const FittedFaces& fitted);

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
