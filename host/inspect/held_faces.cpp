// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/held_faces.hpp"

#include <algorithm>
#include <cmath>

#include "host/inspect/applies_to.hpp"

namespace tetragauge {
namespace {

// Axes of one model, apart by rounding only.
constexpr double kSameAxis_rad = 1e-6;
constexpr double kSameAxis_mm = 1e-5;
// How far the free axis that noisy points show may lie from the model's own: as far as a face from its place.
constexpr double kNearAxis_rad = 0.06;

struct Line {
  Vec3 point_mm, direction;
};

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

double distance_from(const Line& line, const Vec3& point) {
  return (point - line.point_mm).cross(line.direction).norm();
}

// The model's own axis that the free one is, or the free one itself where the model has none near it.
Line axis_meant(const Solid& model, const FreeDirection& free, double near_mm) {
  Line meant{free.point_mm, free.axis};
  double nearest_mm = near_mm;
  for (const Face& face : model.faces()) {
    if (!has_axis(face) && face.type != SurfaceType::torus) continue;
    if (angle_between(face.axis, free.axis) > kNearAxis_rad) continue;
    const double away_mm = distance_from({face.point_on_axis_mm, face.axis}, free.point_mm);
    if (away_mm >= nearest_mm) continue;
    nearest_mm = away_mm;
    meant = {face.point_on_axis_mm, face.axis};
  }
  return meant;
}

bool stays_when_turned(const Face& face, const Line& about) {
  switch (face.type) {
    case SurfaceType::plane:
      return angle_between(face.normal, about.direction) < kNearAxis_rad;
    case SurfaceType::sphere:
      return distance_from(about, face.point_on_axis_mm) < kSameAxis_mm;
    case SurfaceType::cylinder:
    case SurfaceType::cone:
    case SurfaceType::torus:
      return angle_between(face.axis, about.direction) < kSameAxis_rad &&
             distance_from(about, face.point_on_axis_mm) < kSameAxis_mm;
    default:
      return false;
  }
}

bool stays_when_shifted(const Face& face, const Vec3& along) {
  return face.type == SurfaceType::plane ||
         (face.type == SurfaceType::cylinder && angle_between(face.axis, along) < kNearAxis_rad);
}

}  // namespace

std::vector<bool> held_faces(const Solid& model, const std::vector<SetUp>& set_ups) {
  std::vector<bool> held(model.faces().size(), true);
  for (const SetUp& set_up : set_ups) {
    for (const FreeDirection& free : set_up.match.undetermined) {
      const bool turns = free.kind == FreeDirection::Kind::rotation;
      const Line about =
          turns ? axis_meant(model, free, set_up.match.max_offset_mm) : Line{Vec3::Zero(), free.axis};
      for (size_t k = 0; k < held.size(); ++k) {
        const Face& face = model.faces()[k];
        held[k] = held[k] && (turns ? stays_when_turned(face, about) : stays_when_shifted(face, free.axis));
      }
    }
  }
  return held;
}

}  // namespace tetragauge
