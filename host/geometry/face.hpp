// SPDX-License-Identifier: GPL-3.0-or-later
// A face: one connected patch of one surface, of the model or as measured. Both sides of the match speak in
// this type.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/geometry/vec.hpp"

namespace tetragauge {

enum class SurfaceType { plane, cylinder, cone, sphere, torus, other };
std::string_view surface_type_name(SurfaceType type);
std::optional<SurfaceType> surface_type_from_name(std::string_view name);

// Covariance of a fitted plane at point_mm: rows (offset along the normal [mm], tilt about u [rad], tilt
// about v [rad]).
struct PlaneCovariance {
  Mat3 matrix = Mat3::Zero();
  Vec3 u = Vec3::Zero(), v = Vec3::Zero();
};

struct Face {
  int id = 0;       // from 1, canonical order
  int surface = 0;  // faces on the same plane, cylinder, ... share it; from 1
  SurfaceType type = SurfaceType::plane;

  Vec3 normal = Vec3::Zero();  // plane: unit, out of the material
  double d_mm = 0;             // plane: normal . x = d
  Vec3 axis = Vec3::Zero();    // cylinder, cone, torus: unit, towards growing radius for a cone
  double radius_mm = 0;        // cylinder, sphere; cone: at point_on_axis_mm; torus: major
  double minor_radius_mm = 0;  // torus: of the tube
  double half_angle_rad = 0;   // cone
  // cylinder, cone: a point on the axis; sphere, torus: the centre
  Vec3 point_on_axis_mm = Vec3::Zero();
  bool concave = false;  // cylinder, cone, sphere, torus: material outside (a hole, a fillet's hollow)

  Vec3 point_mm = Vec3::Zero();  // centroid of the face's area
  double area_mm2 = 0;
  std::optional<PlaneCovariance> covariance;  // measured planes only
  std::vector<int> neighbours;                // ids, ascending: faces that share an edge
  size_t points = 0;                          // raw points used; 0 for a model
};

// Faces in one frame, mm inside whatever the file's unit was.
struct FaceList {
  std::vector<Face> faces;  // faces[i].id == i + 1 for lists of our own; .hsp lists keep the file's ids
};

}  // namespace tetragauge
