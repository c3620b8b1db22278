// SPDX-License-Identifier: GPL-3.0-or-later
// Deviations of one face from the model's analytic surface, with their uncertainty.
#pragma once

#include "host/geometry/fit_plane.hpp"
#include "host/inspect/cast_scan.hpp"
#include "host/inspect/part_pose.hpp"
#include "host/solid/face_outline.hpp"

namespace tetragauge {

constexpr size_t kLeastPoints = 30;  // fewer are not a measurement

struct FaceMeasurement {
  const Face& face;  // of the model
  const FaceOutline& outline;
  const RayCaster& caster;
  const CastScan& cast;
  const PoseError& pose;
  std::vector<uint32_t> points;  // raw points of this face
  double measured_area_mm2 = 0;  // of the measured faces; 0: none was found
  double tolerance_mm = 0;       // for form: a twentieth of it is the cells' noise; 0: none
  double u_cal_mm = 0;
  double spot_mm = 0;  // radius of the beam
};

// Fills what is measured, or why nothing is; judges nothing. Precondition: at least 3 points.
void measure_face(const FaceMeasurement& in, FaceInspection& out);

// A plane face's plane as its points lie; nullopt where they lie on a line.
std::optional<PlaneFit> fit_along_rays(const FaceMeasurement& in);

// The share of the face's area that has one of its own points within 1.5 of their spacings.
double coverage(const FaceMeasurement& in, double spacing_mm);

// Its two kinds, on the points away from the face's edges.
void measure_plane(const FaceMeasurement& in, FaceInspection& out);
void measure_curve(const FaceMeasurement& in, FaceInspection& out);

// Of a point from a curved face as that was measured: zero but for noise and form where the point is the
// face's. The model's surface itself where it was not measured.
double deviation_as_measured(const Face& face, const FaceInspection& measured, const Vec3& point_mm,
                             double deviation_mm);

// How far residuals larger than sigma promises (form, roughness, an optimistic sigma) widen a variance.
double inflation(double chi2, double freedom);

// rms and peak to valley of what the fit leaves, and form from cells of them; `place` as for form_deviation.
void measure_residuals(const FaceMeasurement& in, std::span<const Vec3> place,
                       std::span<const double> residual_mm, double area_mm2, FaceInspection& out);

}  // namespace tetragauge
