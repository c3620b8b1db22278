// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/head_over_part.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/optics/galvo.hpp"
#include "firmware/optics/psd_camera.hpp"
#include "firmware/optics/stage.hpp"

namespace tetragauge {
namespace {

constexpr double kClearance_mm = 0.01;  // above what the triangles err by, below the size of the spot
// Twice the spot's 1/e^2 radius at the ends of the working volume: room for what the pose errs by.
constexpr double kSpotReach_mm = 0.2;
// A spot near the detector's edge is cut off there.
constexpr double kUsedShareOfDetector = 0.98;

Vector3<double> optics_vector(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

double angle_of_cosine(double cosine) {
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

}  // namespace

HeadOverPart::HeadOverPart(const PlanningMachine& machine, const RigidTransform& T_part_model,
                           const StagePlace& place)
    : machine_(machine),
      T_machine_model_(T_machine_part(machine.head, place.table_deg, place.slide_mm) * T_part_model),
      T_model_machine_(T_machine_model_.inverse()),
      T_part_model_(T_part_model),
      rest_(ray_of_mirrors(machine.head, 0, 0)),
      mirror_mm_(beam(0, 0).origin_mm) {
  for (size_t k = 0; k < 2; ++k) {
    const Vector3<double>& centre = machine.geometry.camera[k].centre;
    camera_mm_[k] = T_model_machine_ * Vec3(centre.x, centre.y, centre.z);
  }
}

std::optional<MirrorAim> HeadOverPart::aim(const Vec3& point_mm) const {
  const MirrorAngles<double> angles =
      aim_mirrors(machine_.head.galvo, optics_vector(T_machine_model_ * point_mm));
  const double limit = machine_.head.mirror_limit_urad * 1e-6;
  if (!angles.reached || std::abs(angles.a_rad) > limit || std::abs(angles.b_rad) > limit)
    return std::nullopt;
  return MirrorAim{static_cast<int32_t>(std::lround(1e6 * angles.a_rad)),
                   static_cast<int32_t>(std::lround(1e6 * angles.b_rad))};
}

MachineRay HeadOverPart::beam(int32_t a_urad, int32_t b_urad) const {
  const MachineRay ray = ray_of_mirrors(machine_.head, a_urad, b_urad);
  return {T_model_machine_ * ray.origin_mm, T_model_machine_.R * ray.direction};
}

bool HeadOverPart::in_volume(const Vec3& spot_mm) const {
  return inside(machine_.geometry.volume, optics_vector(T_part_model_ * spot_mm));
}

void HeadOverPart::ask_cameras(const RayCaster& caster, const Vec3& spot_mm, const Vec3& normal,
                               SpotSight& sight) const {
  const Vector3<double> at = optics_vector(T_machine_model_ * spot_mm);
  bool any_in_sight = false;
  double best_cosine = -1;
  for (size_t k = 0; k < 2; ++k) {
    const CameraGeometry<double>& camera = machine_.geometry.camera[k];
    const double cosine = normal.dot((camera_mm_[k] - spot_mm).normalized());
    if (cosine <= std::cos(kGrazing_rad)) continue;
    bool in_view = false;
    const DetectorPosition<double> image = project(camera, at, &in_view);
    const double edge = kUsedShareOfDetector * camera.half_size_mm;
    if (!in_view || std::abs(image.x_mm) > edge || std::abs(image.y_mm) > edge) continue;
    any_in_sight = true;
    if (caster.occluded(spot_mm, camera_mm_[k], kClearance_mm)) continue;
    ++sight.cameras;
    best_cosine = std::max(best_cosine, cosine);
  }
  sight.obstacle = sight.cameras > 0 ? Obstacle::none
                   : any_in_sight    ? Obstacle::cameras_blocked
                                     : Obstacle::out_of_sight;
  if (sight.cameras > 0) sight.camera_incidence_rad = angle_of_cosine(best_cosine);
}

bool HeadOverPart::may_reach(const Vec3& spot_mm) const {
  const HeadGeometry& head = machine_.head;
  const Vec3 way = T_machine_model_ * spot_mm - rest_.origin_mm;
  // The beam turns twice as far as a mirror; a tenth more than the limit, because mirror a stands before b.
  const double limit = 1.1 * 2e-6 * head.mirror_limit_urad, along = way.dot(rest_.direction);
  return std::abs(std::atan2(way.dot(head.y), along)) <= limit &&
         std::abs(std::atan2(way.dot(head.up), along)) <= limit;
}

SpotSight HeadOverPart::look_at(const RayCaster& caster, const Vec3& spot_mm, const Vec3& normal) const {
  SpotSight sight;
  // Where a beam leaves moves by millimetres with the mirrors' angles.
  if (normal.dot((mirror_mm_ - spot_mm).normalized()) <= std::cos(kGrazing_rad)) return sight;
  sight.obstacle = Obstacle::out_of_reach;
  if (!in_volume(spot_mm) || !may_reach(spot_mm)) return sight;
  ask_cameras(caster, spot_mm, normal, sight);
  if (sight.obstacle == Obstacle::out_of_sight) return sight;
  // Aiming is what costs time: only at what looks well so far.
  if (sight.obstacle == Obstacle::cameras_blocked) {
    if (caster.occluded(mirror_mm_, spot_mm, kClearance_mm)) sight.obstacle = Obstacle::beam_blocked;
    return sight;
  }
  const std::optional<MirrorAim> target = aim(spot_mm);
  if (!target) {
    sight.obstacle = Obstacle::out_of_reach;
    return sight;
  }
  sight.a_urad = target->a_urad;
  sight.b_urad = target->b_urad;
  const MachineRay ray = beam(sight.a_urad, sight.b_urad);
  sight.beam_incidence_rad = angle_of_cosine(-normal.dot(ray.direction));
  if (caster.occluded(ray.origin_mm, spot_mm, kClearance_mm)) sight.obstacle = Obstacle::beam_blocked;
  return sight;
}

SpotSight HeadOverPart::look_along(const RayCaster& caster, const MachineRay& ray, const RayHit& hit) const {
  SpotSight sight;
  const double cosine = -hit.normal.dot(ray.direction);
  if (cosine <= std::cos(kGrazing_rad)) return sight;
  sight.obstacle = Obstacle::out_of_reach;
  if (!in_volume(hit.point_mm)) return sight;
  sight.beam_incidence_rad = angle_of_cosine(cosine);
  ask_cameras(caster, hit.point_mm, hit.normal, sight);
  return sight;
}

bool HeadOverPart::is_clear(const RayCaster& caster, const MachineRay& ray, const RayHit& hit) const {
  std::array<bool, 2> blocked{};
  for (size_t k = 0; k < 2; ++k) blocked[k] = caster.occluded(hit.point_mm, camera_mm_[k], kClearance_mm);
  const auto [u, v] = tangent_frame(ray.direction);
  for (const Vec3& aside : {u, v, Vec3(-u), Vec3(-v)}) {
    const auto rim = caster.first_hit(ray.origin_mm + kSpotReach_mm * aside, ray.direction);
    if (!rim || std::abs(hit.normal.dot(rim->point_mm - hit.point_mm)) > 0.25 * kSpotReach_mm) return false;
    for (size_t k = 0; k < 2; ++k)
      if (caster.occluded(rim->point_mm, camera_mm_[k], kClearance_mm) != blocked[k]) return false;
  }
  return true;
}

}  // namespace tetragauge
