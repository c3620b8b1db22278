// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/applies_to.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tetragauge {
namespace {

constexpr double kSameDirection_rad = 1e-3;

std::string named(const Face& face) {
  return "face " + std::to_string(face.id) + " (" + std::string(surface_type_name(face.type)) + ")";
}

}  // namespace

bool is_parallel(const Vec3& a, const Vec3& b) {
  return a.cross(b).norm() < kSameDirection_rad;
}

bool is_perpendicular(const Vec3& a, const Vec3& b) {
  return std::abs(a.dot(b)) < kSameDirection_rad;
}

bool has_axis(const Face& face) {
  return face.type == SurfaceType::cylinder || face.type == SurfaceType::cone;
}

std::string why_no_radius(const Face& face) {
  if (face.type == SurfaceType::cylinder || face.type == SurfaceType::sphere) return "";
  return named(face) + " has no radius of its own; radius_mm is for cylinders and spheres";
}

std::string why_not_to_datum(std::string_view key, const Face& face, const Datum& datum) {
  const std::string what = std::string(key);
  if (face.id == datum.face) return named(face) + " is datum " + datum.name + " itself";
  const bool is_plane = face.type == SurfaceType::plane;
  if (key == "position_mm") {
    if (is_plane || face.type == SurfaceType::cylinder || face.type == SurfaceType::sphere) return "";
    return named(face) + " has no place that is measured; " + what + " is for planes, cylinders and spheres";
  }
  if (!is_plane && !has_axis(face))
    return named(face) + " has no direction; " + what + " is for planes, cylinders and cones";
  if (key == "angularity_mrad") return "";
  const Vec3& direction = is_plane ? face.normal : face.axis;
  // A plane's normal stands on the plane, an axis lies along its face: right and parallel change places.
  const bool wants_parallel_directions = (key == "parallelism_mm") == is_plane;
  if (wants_parallel_directions ? is_parallel(direction, datum.normal)
                                : is_perpendicular(direction, datum.normal))
    return "";
  double degrees = std::acos(std::min(1.0, std::abs(direction.dot(datum.normal)))) * 180 / std::numbers::pi;
  if (!is_plane) degrees = 90 - degrees;
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), " stands at %.2f degrees to datum %s (face %d), not %s; ", degrees,
                datum.name.c_str(), datum.face, key == "parallelism_mm" ? "parallel" : "at 90 degrees");
  return named(face) + text.data() + "angularity_mrad holds for any angle";
}

}  // namespace tetragauge
