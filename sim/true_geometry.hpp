// SPDX-License-Identifier: GPL-3.0-or-later
// The TRUE geometry of the emulated machine: where laser, mirrors, lenses and detectors really are.
// Deliberately its own numbers and its own formulas: an error in the firmware's geometry or calibration must
// show as an error of the measured points. By default the numbers are the machine's nominal ones; a world
// file makes them differ.
//
// Machine frame (docs/conventions.md): origin on the rotary axis at the table top at slide zero, z up, x
// towards the head, mm and radians.
#pragma once

#include <array>
#include <optional>

#include "host/geometry/rigid_transform.hpp"

namespace tetragauge::sim {

struct Line {
  Vec3 point = Vec3::Zero();
  Vec3 direction = Vec3::UnitX();  // unit
};

// A mirror turning about an axis in its own surface.
struct TrueMirror {
  Vec3 pivot_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  Vec3 normal_at_zero = Vec3::UnitX();
  double zero_rad = 0;  // where it stands when 0 is commanded
  double scale = 1;     // true turn per commanded turn
};

struct TrueCamera {
  RigidTransform T_camera_machine;  // x, y along the detector, z the way it looks; origin in the lens
  double focal_mm = 0;              // lens to detector
  double half_size_mm = 0;          // half the detector's side
  double distortion = 0;  // radial, relative at the detector's half side: r' = r (1 + k (r / half)^2)
};

struct TrueGeometry {
  Line laser;
  TrueMirror mirror_a, mirror_b;  // in the order the beam meets them
  std::array<TrueCamera, 2> cameras;
  Line rotary_axis;  // at slide zero
  Vec3 slide_direction = Vec3::UnitZ();
  Vec3 table_top_normal = Vec3::UnitZ();  // of the table's top, turning with it
};

// The machine as drawn.
TrueGeometry nominal_geometry();

// The beam behind the second mirror; its point is the one where it leaves that mirror. Angles as commanded.
Line beam_of_mirrors(const TrueGeometry& geometry, double a_rad, double b_rad);

// Where on the detector the light of a point arrives, as a share of its half side (-1 .. 1); nullopt: behind
// the lens.
struct DetectorSpot {
  double x = 0, y = 0;
};
std::optional<DetectorSpot> image_on_detector(const TrueCamera& camera, const Vec3& point_mm);

// The table's motion: p_machine = T_machine_part * p_part.
RigidTransform table_pose(const TrueGeometry& geometry, double table_rad, double slide_mm);

}  // namespace tetragauge::sim
