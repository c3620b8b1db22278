// SPDX-License-Identifier: GPL-3.0-or-later
// Raw points averaged into vertices whose spacing stands in a sound proportion to their own noise (DESIGN
// section 5: h = max(s, sqrt(10 sigma s))), never across differing local planes. Every ray is kept.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/scan/scan.hpp"

namespace tetragauge {

struct AveragedPoints {
  std::vector<Vec3> vertices;          // mm, distinct, neighbours in space near each other
  std::vector<float> sigma_mm;         // of the vertex, along its mean ray
  std::vector<Vec3> ray;               // unit, mean direction the light travelled
  std::vector<uint32_t> point_vertex;  // per raw point
  double point_spacing_mm = 0, vertex_spacing_mm = 0;
};

// `spacing_mm` > 0 asks for that spacing of the vertices instead. Does not depend on the order of the points.
AveragedPoints average_points(const Scan& scan, double spacing_mm = 0);

// Which raw points, and so which rays, each vertex has.
struct VertexRays {
  std::vector<uint32_t> first, rays;
  std::span<const uint32_t> of(uint32_t v) const {
    return std::span(rays).subspan(first[v], first[v + 1] - first[v]);
  }
};
VertexRays vertex_rays(const AveragedPoints& averaged);

// The scan's points in an order that depends on their values alone.
std::vector<uint32_t> canonical_order(const Scan& scan);

// One standard deviation along the ray, mm: as the scan says, but never below a millionth of the scan's
// extent (a noiseless scan still has rounding, and statistics divide by sigma).
std::vector<double> floored_sigma_mm(const Scan& scan);

}  // namespace tetragauge
