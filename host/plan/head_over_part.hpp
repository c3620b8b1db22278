// SPDX-License-Identifier: GPL-3.0-or-later
// Whether the machine, with its stage in one place, can measure a spot: the mirrors reach it, beam and a
// camera see it, and at which angle. A machine needs one camera for a point (it is flagged, and a little less
// certain); both are better.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host/plan/machine_time.hpp"
#include "host/solid/ray_caster.hpp"

namespace tetragauge {

// In the order in which they are asked for.
enum class Obstacle : uint8_t {
  turned_away,      // its face looks away from the head
  out_of_reach,     // of the mirrors, or of the working volume
  out_of_sight,     // beside both cameras' detectors, or turned away from both
  beam_blocked,     // by the part
  cameras_blocked,  // both, by the part
  none
};

struct MirrorAim {
  int32_t a_urad = 0, b_urad = 0;
};

struct SpotSight {
  Obstacle obstacle = Obstacle::turned_away;
  int cameras = 0;  // that see it
  // To the surface's normal; of the cameras that see it, the nearer one's.
  double beam_incidence_rad = 0, camera_incidence_rad = 0;
  int32_t a_urad = 0, b_urad = 0;

  bool within(double incidence_rad) const {
    return obstacle == Obstacle::none && beam_incidence_rad <= incidence_rad &&
           camera_incidence_rad <= incidence_rad;
  }
};

// Flatter than this light glances off, and nothing is promised.
inline constexpr double kGrazing_rad = 1.48;  // 85 degrees

class HeadOverPart {
 public:
  HeadOverPart(const PlanningMachine& machine, const RigidTransform& T_part_model, const StagePlace& place);

  // The mirrors' angles for a point; nothing beyond their limit.
  std::optional<MirrorAim> aim(const Vec3& point_mm) const;

  // Model frame.
  SpotSight look_at(const RayCaster& caster, const Vec3& spot_mm, const Vec3& normal) const;
  // The same for what a beam meets, once it is known that it meets it.
  SpotSight look_along(const RayCaster& caster, const MachineRay& ray, const RayHit& hit) const;
  // Whether all of the spot lies on one surface, and every camera sees all of it or nothing: otherwise an
  // edge cuts it, and the point lies somewhere between.
  bool is_clear(const RayCaster& caster, const MachineRay& ray, const RayHit& hit) const;
  // The beam, model frame.
  MachineRay beam(int32_t a_urad, int32_t b_urad) const;

 private:
  void ask_cameras(const RayCaster& caster, const Vec3& spot_mm, const Vec3& normal, SpotSight& sight) const;
  bool in_volume(const Vec3& spot_mm) const;
  bool may_reach(const Vec3& spot_mm) const;  // false: certainly not

  const PlanningMachine& machine_;
  RigidTransform T_machine_model_, T_model_machine_, T_part_model_;
  MachineRay rest_;                // of the beam with both mirrors at zero, machine frame
  Vec3 mirror_mm_;                 // at rest, model frame
  std::array<Vec3, 2> camera_mm_;  // model frame
};

}  // namespace tetragauge
