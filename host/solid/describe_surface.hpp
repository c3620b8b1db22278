// SPDX-License-Identifier: GPL-3.0-or-later
// Type and outward equation of one OpenCASCADE face, its area and centroid.
#pragma once

#include <TopoDS_Face.hxx>

#include "host/geometry/face.hpp"

namespace tetragauge {

// Ids and neighbours are left to the caller.
Face describe_surface(const TopoDS_Face& face);

}  // namespace tetragauge
