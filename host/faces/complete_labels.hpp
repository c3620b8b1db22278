// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "host/faces/assign_points.hpp"

namespace tetragauge {

// For extent only: a label for every vertex of the surface. Vertices on no face (mixed, outliers) go to the
// face around them, crumbs of a face too; what is left in larger numbers is a surface that is no plane, and
// its connected pieces get labels from fits.size() on.
std::vector<int32_t> complete_labels(const Reconstruction& reconstruction, const SurfaceGraph& graph,
                                     const FittedFaces& fitted);

}  // namespace tetragauge
