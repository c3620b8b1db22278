// SPDX-License-Identifier: GPL-3.0-or-later
// Type and outward equation of one OpenCASCADE face, its area and centroid.
#pragma once

#include <TopoDS_Face.hxx>

#include "host/geometry/face.hpp"

namespace tetragauge {

struct DescribedFace {
  Face face;                   // ids and neighbours are left to the caller
  double minor_radius_mm = 0;  // torus
};

DescribedFace describe_surface(const TopoDS_Face& face);

}  // namespace tetragauge
