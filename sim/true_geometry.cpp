// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/true_geometry.hpp"

#include <cmath>
#include <numbers>

namespace tetragauge::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Vec3 turned(const Vec3& v, const Vec3& axis, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, axis) * v;
}

// A ray meets the mirror's surface and leaves it: angle in = angle out. A miss (a ray along the surface)
// cannot happen within the mirrors' +-12 degrees.
Line reflected(const TrueMirror& mirror, const Line& in, double commanded_rad) {
  const Vec3 normal =
      turned(mirror.normal_at_zero, mirror.axis, mirror.zero_rad + mirror.scale * commanded_rad);
  const double way = normal.dot(mirror.pivot_mm - in.point) / normal.dot(in.direction);
  return {in.point + way * in.direction, in.direction - 2 * normal.dot(in.direction) * normal};
}

TrueCamera camera_looking(const Vec3& from, const Vec3& at, const Vec3& up) {
  const Vec3 z = (at - from).normalized();
  TrueCamera camera;
  camera.T_camera_machine.R.row(0) = up.cross(z);
  camera.T_camera_machine.R.row(1) = up;
  camera.T_camera_machine.R.row(2) = z;
  camera.T_camera_machine.t = -(camera.T_camera_machine.R * from);
  camera.focal_mm = 35;
  camera.half_size_mm = 10;
  return camera;
}

}  // namespace

TrueGeometry nominal_geometry() {
  // The plate stands 350 mm from the point aimed at, 200 mm above the table top at slide zero, and looks 35
  // degrees down. Its lenses sit where it is cut by lines through that point at 22.5 degrees to the middle.
  const Vec3 aim(0, 0, 200);
  const Vec3 left = Vec3::UnitY();
  const Vec3 forward = turned(-Vec3::UnitX(), left, -35 * kDegree);
  const Vec3 up = turned(Vec3::UnitZ(), left, -35 * kDegree);
  const Vec3 head = aim - 350 * forward;

  TrueGeometry geometry;
  // Laser from the left onto mirror a, 10 mm above mirror b, which throws the beam forward.
  geometry.laser = {head + 10 * up + 30 * left, -left};
  geometry.mirror_a = {
      .pivot_mm = head + 10 * up, .axis = -forward, .normal_at_zero = (left - up).normalized()};
  geometry.mirror_b = {.pivot_mm = head, .axis = left, .normal_at_zero = (forward + up).normalized()};
  const double aside_mm = 350 * std::tan(22.5 * kDegree);
  geometry.cameras[0] = camera_looking(head + aside_mm * left, aim, up);
  geometry.cameras[1] = camera_looking(head - aside_mm * left, aim, up);
  geometry.rotary_axis = {Vec3::Zero(), Vec3::UnitZ()};
  geometry.slide_direction = Vec3::UnitZ();
  return geometry;
}

Line beam_of_mirrors(const TrueGeometry& geometry, double a_rad, double b_rad) {
  return reflected(geometry.mirror_b, reflected(geometry.mirror_a, geometry.laser, a_rad), b_rad);
}

std::optional<DetectorSpot> image_on_detector(const TrueCamera& camera, const Vec3& point_mm) {
  const Vec3 p = camera.T_camera_machine * point_mm;
  if (p.z() <= camera.focal_mm) return std::nullopt;
  const double to_share = camera.focal_mm / (p.z() * camera.half_size_mm);
  const double x = p.x() * to_share, y = p.y() * to_share;
  const double stretch = 1 + camera.distortion * (x * x + y * y);
  return DetectorSpot{x * stretch, y * stretch};
}

RigidTransform table_pose(const TrueGeometry& geometry, double table_rad, double slide_mm) {
  const Line& axis = geometry.rotary_axis;
  const Mat3 turn = Eigen::AngleAxisd(table_rad, axis.direction).toRotationMatrix();
  return {turn, axis.point - turn * axis.point + slide_mm * geometry.slide_direction};
}

}  // namespace tetragauge::sim
