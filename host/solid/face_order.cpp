// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/face_order.hpp"

#include <cmath>

namespace tetragauge {
namespace {

// Faces on one surface as exporters, Booleans and six-digit matrices leave them: directions agree to this
// angle, places to this distance at the faces themselves.
constexpr double kSameAngle_rad = 5e-6;
constexpr double kSamePlace_mm = 1e-4;

// Steps of the canonical order: far above rounding, far below what tells two faces apart.
constexpr double kDirectionStep = 1e-5;
constexpr double kLengthStep_mm = 1e-4;

bool is_same_direction(const Vec3& a, const Vec3& b) {
  return a.cross(b).norm() < kSameAngle_rad && a.dot(b) > 0;
}

double distance_to_axis(const Face& face, const Vec3& p) {
  return face.axis.cross(p - face.point_on_axis_mm).norm();
}

}  // namespace

FaceKey canonical_key(const Face& face) {
  const auto direction = [](double x) { return std::llround(x / kDirectionStep); };
  const auto length = [](double x) { return std::llround(x / kLengthStep_mm); };
  const Vec3 way = face.type == SurfaceType::plane ? face.normal : face.axis;
  // A point on an axis slides along it; only the foot of the origin on it is the surface's own.
  const bool has_axis = face.type == SurfaceType::cylinder || face.type == SurfaceType::cone;
  const Vec3 place = has_axis ? Vec3(face.point_on_axis_mm - face.axis * face.axis.dot(face.point_on_axis_mm))
                              : face.point_on_axis_mm;
  return {static_cast<int64_t>(face.type),
          direction(way.x()),
          direction(way.y()),
          direction(way.z()),
          length(face.d_mm),
          length(face.type == SurfaceType::cone ? face.half_angle_rad : face.radius_mm),
          length(face.minor_radius_mm),
          length(place.x()),
          length(place.y()),
          length(place.z()),
          length(face.point_mm.x()),
          length(face.point_mm.y()),
          length(face.point_mm.z()),
          length(face.area_mm2)};
}

bool is_same_surface(const Face& a, const Face& b) {
  if (a.type != b.type || a.concave != b.concave) return false;
  const auto is_same_length = [](double x, double y) { return std::abs(x - y) < kSamePlace_mm; };
  switch (a.type) {
    case SurfaceType::plane:
      return is_same_direction(a.normal, b.normal) && is_same_length(a.normal.dot(b.point_mm), a.d_mm) &&
             is_same_length(b.normal.dot(a.point_mm), b.d_mm);
    case SurfaceType::cylinder:
      return is_same_direction(a.axis, b.axis) && is_same_length(a.radius_mm, b.radius_mm) &&
             distance_to_axis(a, b.point_on_axis_mm) < kSamePlace_mm;
    case SurfaceType::cone: {
      const double along = a.axis.dot(b.point_on_axis_mm - a.point_on_axis_mm);
      return is_same_direction(a.axis, b.axis) &&
             std::abs(a.half_angle_rad - b.half_angle_rad) < kSameAngle_rad &&
             distance_to_axis(a, b.point_on_axis_mm) < kSamePlace_mm &&
             is_same_length(a.radius_mm + along * std::tan(a.half_angle_rad), b.radius_mm);
    }
    case SurfaceType::sphere:
      return is_same_length(a.radius_mm, b.radius_mm) &&
             (a.point_on_axis_mm - b.point_on_axis_mm).norm() < kSamePlace_mm;
    case SurfaceType::torus:
      return is_same_direction(a.axis, b.axis) && is_same_length(a.radius_mm, b.radius_mm) &&
             is_same_length(a.minor_radius_mm, b.minor_radius_mm) &&
             (a.point_on_axis_mm - b.point_on_axis_mm).norm() < kSamePlace_mm;
    case SurfaceType::other:
      return false;
  }
  return false;
}

void number_surfaces(std::vector<Face>& faces, const std::function<bool(const Face&, const Face&)>& is_same) {
  int surfaces = 0;
  for (size_t i = 0; i < faces.size(); ++i) {
    faces[i].surface = 0;
    for (size_t j = 0; j < i && faces[i].surface == 0; ++j) {
      if (is_same(faces[j], faces[i])) faces[i].surface = faces[j].surface;
    }
    if (faces[i].surface == 0) faces[i].surface = ++surfaces;
  }
}

}  // namespace tetragauge
