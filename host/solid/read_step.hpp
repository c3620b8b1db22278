// SPDX-License-Identifier: GPL-3.0-or-later
// STEP files through OpenCASCADE, in mm whatever unit they declare.
#pragma once

#include <TopoDS_Shape.hxx>
#include <string>

#include "host/base/result.hpp"

namespace tetragauge {

struct StepModel {
  TopoDS_Shape shape;         // mm
  std::string declared_unit;  // as the file says: "mm", "inch", ...
};

// May throw Standard_Failure from within OpenCASCADE.
Result<StepModel> read_step(const std::string& content, const std::string& file);

}  // namespace tetragauge
