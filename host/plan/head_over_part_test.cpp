// SPDX-License-Identifier: GPL-3.0-or-later
// What the planner says of single spots against what the emulated machine measures there: its optics and its
// part are sim/'s, which shares no code with the planner's.
#include "host/plan/head_over_part.hpp"

#include <random>

#include "firmware/optics/psd_camera.hpp"
#include "host/plan/face_patches.hpp"
#include "host/plan/test_parts.hpp"
#include "host/session/measure_rays.hpp"

namespace tetragauge {
namespace {

// Neither flat to beam or camera nor near its detector's edge: there the machine may see a little more or
// less than is promised.
bool is_plain(const PlanningMachine& machine, const RigidTransform& T_machine_part, const Vec3& spot_mm,
              const Vec3& normal) {
  const Vec3 at = T_machine_part * spot_mm, n = T_machine_part.R * normal;
  if (std::abs(n.dot((ray_of_mirrors(machine.head, 0, 0).origin_mm - at).normalized())) < 0.12) return false;
  for (const CameraGeometry<double>& camera : machine.geometry.camera) {
    const Vec3 to_camera = (Vec3(camera.centre.x, camera.centre.y, camera.centre.z) - at).normalized();
    if (std::abs(n.dot(to_camera)) < 0.12) return false;
    bool in_view = false;
    const auto image = project(camera, Vector3<double>{at.x(), at.y(), at.z()}, &in_view);
    const double furthest = std::max(std::abs(image.x_mm), std::abs(image.y_mm)) / camera.half_size_mm;
    if (furthest > 0.97 && furthest < 1.01) return false;
  }
  return true;
}

TEST(HeadOverPart, ForetellsWhatTheMachineMeasures) {
  const test::PlacedPart part = test::placed(test::kSlotted);
  auto session = start_session({.part = part.file});
  ASSERT_TRUE(session) << session.error().message;
  const auto machine = read_machine(*session->link);
  ASSERT_TRUE(machine) << machine.error().message;

  const std::vector<Patch> patches = face_patches(part.model, part.caster);
  std::mt19937 random(20261122);
  struct Asked {
    Vec3 spot_mm;
    SpotSight sight;
    bool is_clear = false;
  };
  std::vector<SingleRay> rays;
  std::vector<Asked> asked;
  std::map<Obstacle, size_t> of_kind;
  for (int n = 0; n < 3000; ++n) {
    const StagePlace place{15.0 * static_cast<double>(random() % 24),
                           60.0 + 30.0 * static_cast<double>(random() % 7)};
    const Patch& patch = patches[random() % patches.size()];
    if (!(patch.area_mm2 > 0)) continue;  // in a corner: other faces are as near
    const HeadOverPart head(*machine, part.T_part_model, place);
    const SpotSight sight = head.look_at(part.caster, patch.point_mm, patch.normal);
    const auto aim = head.aim(patch.point_mm);
    if (!aim || of_kind[sight.obstacle]++ >= 250) continue;
    const MachineRay ray = head.beam(aim->a_urad, aim->b_urad);
    const auto hit = part.caster.first_hit(ray.origin_mm, ray.direction);
    rays.push_back({place.table_deg, place.slide_mm, aim->a_urad, aim->b_urad});
    const Vec3 spot = part.T_part_model * patch.point_mm;
    const RigidTransform T = T_machine_part(machine->head, place.table_deg, place.slide_mm);
    const bool is_sure = is_plain(*machine, T, spot, part.T_part_model.R * patch.normal);
    asked.push_back({spot, sight, hit && is_sure && head.is_clear(part.caster, ray, *hit)});
  }
  EXPECT_GT(of_kind[Obstacle::none], 200u);
  EXPECT_GT(of_kind[Obstacle::beam_blocked], 100u);
  EXPECT_GT(of_kind[Obstacle::cameras_blocked], 20u);
  EXPECT_GT(of_kind[Obstacle::turned_away], 200u);

  const auto measured = measure_rays(*session->link, rays, 16, {.keep_table = true});
  ASSERT_TRUE(measured) << measured.error().message;
  // A point belongs to the spot it is nearest to along its own beam: the beams are told apart by where they
  // start and go.
  const Scan& scan = measured->scan;
  std::map<Obstacle, size_t> wrong;
  for (size_t k = 0; k < rays.size(); ++k) {
    const HeadOverPart head(*machine, {}, {rays[k].table_deg, rays[k].slide_mm});
    const MachineRay ray = head.beam(rays[k].a_urad, rays[k].b_urad);
    bool found = false, flagged = false;
    for (size_t i = 0; i < scan.size(); ++i) {
      if ((scan.ray_origins[i] - ray.origin_mm).norm() > 0.01) continue;
      if (scan.ray_direction(i).cross(ray.direction).norm() > 5e-4) continue;
      // Another surface ends half a spot away at the nearest.
      const bool is_seen = asked[k].sight.obstacle == Obstacle::none;
      if ((scan.points[i] - asked[k].spot_mm).norm() > (is_seen ? 0.5 : 0.15)) continue;
      found = true;
      flagged = (scan.flags[i] & kPointOneCamera) != 0;
    }
    const SpotSight& sight = asked[k].sight;
    if (sight.obstacle != Obstacle::none) {
      // Near an edge part of the spot may get by.
      wrong[sight.obstacle] += found && asked[k].is_clear;
    } else if (sight.beam_incidence_rad < 1.13 && asked[k].is_clear) {
      wrong[Obstacle::none] += !found || flagged != (sight.cameras == 1);
    }
  }
  for (const auto& [obstacle, count] : wrong) EXPECT_EQ(count, 0u) << static_cast<int>(obstacle);
}

}  // namespace
}  // namespace tetragauge
