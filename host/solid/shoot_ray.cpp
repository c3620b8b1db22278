// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/shoot_ray.hpp"

#include <tbb/task_arena.h>

namespace tetragauge {

RTCRayHit ray_query(const Vec3& start, const Vec3& direction, double near, double far) {
  RTCRayHit query{};
  query.ray.org_x = static_cast<float>(start.x());
  query.ray.org_y = static_cast<float>(start.y());
  query.ray.org_z = static_cast<float>(start.z());
  query.ray.dir_x = static_cast<float>(direction.x());
  query.ray.dir_y = static_cast<float>(direction.y());
  query.ray.dir_z = static_cast<float>(direction.z());
  query.ray.tnear = static_cast<float>(near);
  query.ray.tfar = static_cast<float>(far);
  query.ray.mask = 0xFFFFFFFFu;  // Debian's Embree tests masks: without this nothing is hit
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return query;
}

void commit_scene(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  // One thread: the tree, and with it which of two triangles at one distance is named, is always the same.
  tbb::task_arena(1).execute([&] { rtcJoinCommitScene(scene); });
}

}  // namespace tetragauge
