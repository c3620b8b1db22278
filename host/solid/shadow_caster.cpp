// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/shadow_caster.hpp"

#include <algorithm>

#include "host/solid/shoot_ray.hpp"

namespace tetragauge {

struct ShadowCaster::Scene {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene triangles = rtcNewScene(device);
  Vec3 centre;

  explicit Scene(const Solid& solid) : centre(0.5 * (solid.box_min_mm + solid.box_max_mm)) {
    rtcSetSceneFlags(triangles, RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), solid.vertices.size()));
    for (const Vec3& p : solid.vertices) {
      for (int i = 0; i < 3; ++i) *vertices++ = static_cast<float>(p[i] - centre[i]);
    }
    auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), solid.triangles.size()));
    for (const auto& triangle : solid.triangles) {
      indices = std::copy(triangle.begin(), triangle.end(), indices);
    }
    commit_scene(triangles, geometry);
  }
  ~Scene() {
    rtcReleaseScene(triangles);
    rtcReleaseDevice(device);
  }
};

ShadowCaster::ShadowCaster(const Solid& solid) : scene_(std::make_unique<Scene>(solid)) {}
ShadowCaster::~ShadowCaster() = default;
ShadowCaster::ShadowCaster(ShadowCaster&&) noexcept = default;
ShadowCaster& ShadowCaster::operator=(ShadowCaster&&) noexcept = default;

bool ShadowCaster::occluded(const Vec3& a, const Vec3& b) const {
  const double length = (b - a).norm();
  if (!(length > 0)) return false;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = ray_query(a - scene_->centre, (b - a) / length, 0, length).ray;
  rtcOccluded1(scene_->triangles, &context, &ray);
  return ray.tfar < 0;  // Embree's sign of a hit
}

}  // namespace tetragauge
