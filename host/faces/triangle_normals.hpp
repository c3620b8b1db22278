// SPDX-License-Identifier: GPL-3.0-or-later
// What the thesis's two ways of clustering work on: triangles with their normals, made better by their
// neighbours, and which of them can be trusted to lie on one face.
#pragma once

#include <cstdint>
#include <vector>

#include "host/faces/surface_graph.hpp"

namespace tetragauge {

struct FacetElement {
  uint32_t triangle = 0;  // of the surface
  Vec3 normal = Vec3::Zero(), centre = Vec3::Zero();
  double normal_sigma = 0;     // rad
  double height_sigma_mm = 0;  // of the centre, across
  double area_mm2 = 0;
  std::vector<uint32_t> neighbours;  // elements across its edges
};

// The seen triangles whose normals agree with those of their neighbours within noise: a strip across an edge,
// one triangle wide, does not. Neighbour correction: each normal becomes the mean of its own and, times
// `neighbour_weight`, its neighbours', as often as it takes to average over a face's width. 0: normals as
// they are.
std::vector<FacetElement> facet_elements(const Reconstruction& reconstruction, double neighbour_weight);

}  // namespace tetragauge
