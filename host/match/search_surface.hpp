// SPDX-License-Identifier: GPL-3.0-or-later
// Poses in which a scan's points lie near the model's surface, with no start and no planes.
#pragma once

#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/match/surface_problem.hpp"

namespace tetragauge {

struct SurfacePose {
  RigidTransform T_model_part;
  double misfit = 0;
};

// Of poses alike one; the least misfit first. Same result for any number of threads.
std::vector<SurfacePose> search_surface(const SurfaceProblem& problem);

}  // namespace tetragauge
