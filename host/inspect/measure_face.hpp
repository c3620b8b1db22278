// SPDX-License-Identifier: GPL-3.0-or-later
// Deviations of one face from the model's analytic surface, with their uncertainty.
#pragma once

#include "host/inspect/cast_scan.hpp"
#include "host/inspect/face_outline.hpp"
#include "host/inspect/inspect.hpp"

namespace tetragauge {

struct FaceMeasurement {
  const Face& face;  // of the model
  const FaceOutline& outline;
  const CastScan& cast;
  std::vector<uint32_t> points;  // raw points of this face
  double measured_area_mm2 = 0;  // of the measured faces; 0: none was found
  double tolerance_mm = 0;       // for form: a twentieth of it is the cells' noise; 0: none
  double u_cal_mm = 0;
};

// The share of the face's area that has one of its own points within 1.5 of their spacings.
double coverage(const FaceMeasurement& in, double spacing_mm);

// Fills what is measured; judges nothing. Precondition: at least 3 points.
void measure_face(const FaceMeasurement& in, const Match& match, FaceInspection& out);

}  // namespace tetragauge
