// SPDX-License-Identifier: GPL-3.0-or-later
// Faces of which all points lie off their place together: too large, too small or shifted, and no reason to
// doubt the pose.
#pragma once

#include <map>

#include "host/match/surface_scatter.hpp"

namespace tetragauge {

// By how much each face as a whole lies off its place, as far as that is no chance and at most `most_out_mm`;
// by the model's index.
std::map<int, double> faces_out(const std::vector<RayResidual>& residuals, const SurfaceScatter& scatter,
                                double most_out_mm);

// Rays that speak against a pose, as a share: their point lies farther than `limit_mm` (or three of its own
// standard deviations) off the surface, or as far below another part of the model that the light came
// through. A face that lies off its place as a whole, by at most `most_out_mm`, is out of size or place,
// which is what the inspection is to find: its points are judged from where it lies. What such faces say
// about the pose is left out of it likewise (polish_with_faces_out).
double share_against(const std::vector<RayResidual>& residuals, const SurfaceScatter& scatter,
                     double limit_mm, double most_out_mm);

}  // namespace tetragauge
