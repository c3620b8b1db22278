// SPDX-License-Identifier: GPL-3.0-or-later
// What was found, for a person to look at.
#pragma once

#include <string>

#include "host/faces/find_faces.hpp"
#include "host/faces/picture.hpp"

namespace tetragauge {

// The surface from four sides that together show everything convex: each face in its colour and with its
// number, edges of the boundary model as lines, surface on no face light grey, unseen surface dark grey.
Picture draw_four_views(const Reconstruction& reconstruction, const MeasuredFaces& faces);

// The extended Gaussian sphere from both sides: a disc at each face's normal, its area that of the face.
Picture draw_gaussian_sphere(const MeasuredFaces& faces);

// PLY of the surface with a colour and the face's id (0: none, -1: unseen) on each triangle.
std::string coloured_surface_ply(const Reconstruction& reconstruction, const MeasuredFaces& faces);

}  // namespace tetragauge
