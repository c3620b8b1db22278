// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/head_geometry.hpp"

#include <cmath>
#include <numbers>

#include "firmware/optics/stage.hpp"

namespace tetragauge {
namespace {

Vector3<double> optics_vector(const tg_Vector& v) {
  return {v.x, v.y, v.z};
}
Vec3 host_vector(const Vector3<double>& v) {
  return {v.x, v.y, v.z};
}
Vector3<double> optics_vector(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

GalvoGeometry<double> galvo_geometry(const tg_GalvoConfig& from) {
  GalvoGeometry<double> galvo;
  galvo.beam_point = optics_vector(from.beam_point_mm);
  galvo.beam_direction = optics_vector(from.beam_direction);
  galvo.a_point = optics_vector(from.a_point_mm);
  galvo.a_axis = optics_vector(from.a_axis);
  galvo.a_normal = optics_vector(from.a_normal);
  galvo.b_point = optics_vector(from.b_point_mm);
  galvo.b_axis = optics_vector(from.b_axis);
  galvo.b_normal = optics_vector(from.b_normal);
  galvo.a_zero_rad = from.a_zero_urad * 1e-6;
  galvo.b_zero_rad = from.b_zero_urad * 1e-6;
  galvo.a_scale = from.a_scale;
  galvo.b_scale = from.b_scale;
  galvo.direction_sigma_rad = from.direction_sigma_urad * 1e-6;
  return galvo;
}

int32_t to_urad(double rad) {
  return static_cast<int32_t>(std::lround(rad * 1e6));
}

}  // namespace

HeadGeometry head_geometry(const tg_GalvoConfig& galvo, const tg_StageConfig& stage) {
  HeadGeometry head;
  head.galvo = galvo_geometry(galvo);
  head.stage.axis_point = optics_vector(stage.axis_point_mm);
  head.stage.axis_direction = optics_vector(stage.axis_direction);
  head.stage.slide_direction = optics_vector(stage.slide_direction);
  head.mirror_limit_urad = galvo.limit_urad;

  const MachineRay rest = ray_of_mirrors(head, 0, 0);
  // Foot of the common perpendicular of beam and rotary axis, on the beam.
  const Vec3 axis_point = host_vector(head.stage.axis_point), axis = host_vector(head.stage.axis_direction);
  const double along = rest.direction.dot(axis);
  const Vec3 between = axis_point - rest.origin_mm;
  const double range = (between.dot(rest.direction) - along * between.dot(axis)) / (1 - along * along);
  head.aim_mm = rest.origin_mm + range * rest.direction;
  head.y = axis.cross(-rest.direction).normalized();
  head.up = (-rest.direction).cross(head.y);
  return head;
}

MachineRay ray_of_mirrors(const HeadGeometry& head, int32_t a_urad, int32_t b_urad) {
  const Beam<double> beam = beam_from_mirrors(head.galvo, a_urad * 1e-6, b_urad * 1e-6);
  return {host_vector(beam.origin), host_vector(beam.direction)};
}

RigidTransform T_machine_part(const HeadGeometry& head, double table_deg, double slide_mm) {
  const Vec3 axis = host_vector(head.stage.axis_direction);
  return {Eigen::AngleAxisd(table_deg * std::numbers::pi / 180, axis).toRotationMatrix(),
          host_vector(head.stage.axis_point) + slide_mm * host_vector(head.stage.slide_direction)};
}

Result<tg_View> lay_raster(const HeadGeometry& head, const PlannedView& view) {
  const auto angles = [&](double y_mm, double up_mm) {
    return aim_mirrors(head.galvo, optics_vector(head.aim_mm + y_mm * head.y + up_mm * head.up));
  };
  const RasterWindow& w = view.window;
  // Mirror a alone moves the beam along y, b along up (a's centre of rotation lies beyond b).
  const auto left = angles(w.y_min_mm, 0), right = angles(w.y_max_mm, 0);
  const auto low = angles(0, w.up_min_mm), high = angles(0, w.up_max_mm);
  const double limit = head.mirror_limit_urad * 1e-6;
  for (const auto& corner : {left, right, low, high}) {
    if (!corner.reached || std::abs(corner.a_rad) > limit || std::abs(corner.b_rad) > limit) {
      return bad_input("the plan's window reaches beyond the mirrors' limit; narrow window_mm");
    }
  }
  const auto count = [&](double span_mm) {
    return static_cast<uint32_t>(std::floor(span_mm / view.pitch_mm + 1e-9)) + 1;
  };
  tg_View out = tg_View_init_zero;
  out.columns = count(w.y_max_mm - w.y_min_mm);
  out.rows = count(w.up_max_mm - w.up_min_mm);
  const auto step = [](double from, double to, uint32_t number) {
    return number > 1 ? to_urad((to - from) / (number - 1)) : 0;
  };
  out.a_step_urad = step(left.a_rad, right.a_rad, out.columns);
  out.b_step_urad = step(low.b_rad, high.b_rad, out.rows);
  // Centred, so that rounding the step to a microradian shifts nothing.
  out.a_first_urad =
      to_urad(0.5 * (left.a_rad + right.a_rad)) - static_cast<int32_t>(out.columns - 1) * out.a_step_urad / 2;
  out.b_first_urad =
      to_urad(0.5 * (low.b_rad + high.b_rad)) - static_cast<int32_t>(out.rows - 1) * out.b_step_urad / 2;
  out.table_udeg = static_cast<int32_t>(std::lround(view.table_deg * 1e6));
  out.slide_um = static_cast<int32_t>(std::lround(view.slide_mm * 1e3));
  out.samples = view.samples;
  return out;
}

}  // namespace tetragauge
