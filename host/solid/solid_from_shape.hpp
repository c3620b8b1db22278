// SPDX-License-Identifier: GPL-3.0-or-later
// An OpenCASCADE shape as a Solid: distinct closed solids, split faces merged, faces listed, tessellated.
#pragma once

#include <TopoDS_Shape.hxx>
#include <string>

#include "host/solid/solid.hpp"

namespace tetragauge {

// `place` names the file in errors. May throw Standard_Failure from within OpenCASCADE.
Result<Solid> solid_from_shape(const TopoDS_Shape& shape, const std::string& place,
                               const ReadSolidOptions& options);

}  // namespace tetragauge
