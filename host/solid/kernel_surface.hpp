// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <TopoDS_Face.hxx>
#include <memory>

#include "host/solid/parametric_surface.hpp"

namespace tetragauge {

// The surface of a face, in mm, at the place the face has.
std::shared_ptr<const ParametricSurface> kernel_surface(const TopoDS_Face& face);

}  // namespace tetragauge
