// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/ray_caster.hpp"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/solid/solve_hit.hpp"

namespace tetragauge {
namespace {

// Embree computes in float: what it says of a distance along a ray that starts at the box is right to this
// share of the box's diagonal.
constexpr double kFloat = 4e-7;

struct Crossing {
  double t = 0;  // along the ray
  uint32_t triangle = 0;
  bool is_entering = false;
};

// Candidates of one ray, gathered in one traversal.
struct GatheringContext {
  RTCIntersectContext context;  // first, so that Embree's pointer to it is a pointer to this
  std::vector<uint32_t>* triangles;
};

void gather_hit(const RTCFilterFunctionNArguments* arguments) {
  const auto* gathering = reinterpret_cast<const GatheringContext*>(arguments->context);
  gathering->triangles->push_back(RTCHitN_primID(arguments->hit, arguments->N, 0));
  arguments->valid[0] = 0;  // go on to the next
}

}  // namespace

struct RayCaster::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<Face> faces;
  std::vector<Vec3> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> triangle_face;
  Vec3 centre = Vec3::Zero(), half = Vec3::Zero();  // the box, widened
  double diagonal_mm = 0;
  bool is_all_plane = true;

  ~Scene() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  // Where the ray passes the box; nullopt if it does not.
  std::optional<std::pair<double, double>> clip(const Vec3& origin, const Vec3& direction) const {
    double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
    for (int i = 0; i < 3; ++i) {
      const double r = centre[i] - origin[i];
      if (direction[i] == 0) {
        if (std::abs(r) > half[i]) return std::nullopt;
        continue;
      }
      const double a = (r - half[i]) / direction[i], b = (r + half[i]) / direction[i];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (!(enter <= leave)) return std::nullopt;
    return std::pair{enter, leave};
  }

  RTCRay ray(const Vec3& start, const Vec3& direction, double near, double far) const {
    const Vec3 o = start - centre;
    RTCRay ray{};
    ray.org_x = static_cast<float>(o.x());
    ray.org_y = static_cast<float>(o.y());
    ray.org_z = static_cast<float>(o.z());
    ray.dir_x = static_cast<float>(direction.x());
    ray.dir_y = static_cast<float>(direction.y());
    ray.dir_z = static_cast<float>(direction.z());
    ray.tnear = static_cast<float>(near);
    ray.tfar = static_cast<float>(far);
    ray.mask = 0xFFFFFFFFu;  // Debian's Embree tests masks: without this nothing is hit
    return ray;
  }

  Vec3 triangle_normal(uint32_t triangle) const {
    const auto& t = triangles[triangle];
    return (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]);
  }

  // The crossing on the analytic face that belongs to a triangle Embree named; `t_float` is its distance.
  Crossing refine(const Vec3& origin, const Vec3& direction, uint32_t triangle, double t_float) const {
    const Vec3 normal = triangle_normal(triangle);
    const double closing = normal.dot(direction);
    double t = t_float;
    if (closing != 0) {
      const double exact = normal.dot(vertices[triangles[triangle][0]] - origin) / closing;
      // A triangle seen edge-on has no crossing of its own to speak of.
      if (std::abs(exact - t_float) < diagonal_mm) t = exact;
    }
    const Face& face = faces[triangle_face[triangle]];
    const std::optional<double> step = solve_hit(face, origin + t * direction, direction, closing < 0);
    if (step && std::abs(*step) < diagonal_mm) t += *step;
    return {t, triangle, closing < 0};
  }

  RayHit hit_of(const Vec3& origin, const Vec3& direction, const Crossing& crossing) const {
    RayHit hit;
    hit.distance_mm = crossing.t;
    hit.point_mm = origin + crossing.t * direction;
    hit.face = static_cast<int>(triangle_face[crossing.triangle]);
    hit.normal = surface_normal(faces[triangle_face[crossing.triangle]], hit.point_mm);
    if (hit.normal.isZero()) hit.normal = triangle_normal(crossing.triangle).normalized();
    return hit;
  }

  // Every crossing of the whole line, ascending.
  std::vector<Crossing> all_crossings(const Vec3& origin, const Vec3& direction) const {
    const auto span = clip(origin, direction);
    if (!span) return {};
    std::vector<uint32_t> candidates;
    GatheringContext gathering{{}, &candidates};
    rtcInitIntersectContext(&gathering.context);
    gathering.context.filter = gather_hit;
    RTCRayHit query{};
    query.ray = ray(origin + span->first * direction, direction, 0, span->second - span->first);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &gathering.context, &query);
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    std::vector<Crossing> crossings;
    for (const uint32_t triangle : candidates) {
      const Vec3 normal = triangle_normal(triangle);
      const double closing = normal.dot(direction);
      if (closing == 0) continue;
      const double t = normal.dot(vertices[triangles[triangle][0]] - origin) / closing;
      crossings.push_back(refine(origin, direction, triangle, t));
    }
    std::stable_sort(crossings.begin(), crossings.end(),
                     [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
    return crossings;
  }
};

RayCaster::RayCaster(const Solid& solid) : scene_(std::make_unique<Scene>()) {
  Scene& s = *scene_;
  s.faces = solid.faces();
  s.vertices = solid.vertices;
  s.triangles = solid.triangles;
  s.triangle_face = solid.triangle_face;
  s.is_all_plane = std::all_of(s.faces.begin(), s.faces.end(),
                               [](const Face& face) { return face.type == SurfaceType::plane; });
  s.centre = 0.5 * (solid.box_min_mm + solid.box_max_mm);
  s.diagonal_mm = std::max((solid.box_max_mm - solid.box_min_mm).norm(), 1e-6);
  s.half = 0.5 * (solid.box_max_mm - solid.box_min_mm) + Vec3::Constant(1e-3 * s.diagonal_mm);

  s.device = rtcNewDevice(nullptr);
  s.scene = rtcNewScene(s.device);
  rtcSetSceneFlags(
      s.scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
  // Spatial splits of the high quality would report a triangle twice.
  rtcSetSceneBuildQuality(s.scene, RTC_BUILD_QUALITY_MEDIUM);
  const RTCGeometry geometry = rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), s.vertices.size()));
  for (const Vec3& p : s.vertices) {
    for (int i = 0; i < 3; ++i) *vertices++ = static_cast<float>(p[i] - s.centre[i]);
  }
  auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), s.triangles.size()));
  for (const auto& triangle : s.triangles) indices = std::copy(triangle.begin(), triangle.end(), indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(s.scene, geometry);
  rtcReleaseGeometry(geometry);
  // One thread: the tree, and with it which of two triangles at one distance is named, is always the same.
  tbb::task_arena(1).execute([&] { rtcJoinCommitScene(s.scene); });
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

std::optional<RayHit> RayCaster::first_hit(const Vec3& origin, const Vec3& direction, double from_mm) const {
  const Scene& s = *scene_;
  const auto span = s.clip(origin, direction);
  if (!span || span->second < from_mm) return std::nullopt;
  const double margin = kFloat * s.diagonal_mm;
  // A curved face's triangles may lie before `from_mm` where the face itself lies beyond it.
  const double start = s.is_all_plane ? std::max(span->first, from_mm - 100 * margin) : span->first;
  const double length = span->second - start;
  double near = 0;
  for (;;) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    query.ray = s.ray(origin + start * direction, direction, near, length);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(s.scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const double t = start + static_cast<double>(query.ray.tfar);
    const Crossing crossing = s.refine(origin, direction, query.hit.primID, t);
    if (crossing.t > from_mm) return s.hit_of(origin, direction, crossing);
    near = static_cast<double>(query.ray.tfar) + margin;
  }
}

bool RayCaster::occluded(const Vec3& a, const Vec3& b, double clearance_mm) const {
  const double length = (b - a).norm();
  if (!(length > 2 * clearance_mm)) return false;
  const auto hit = first_hit(a, (b - a) / length, clearance_mm);
  return hit && hit->distance_mm < length - clearance_mm;
}

bool RayCaster::inside(const Vec3& p) const {
  // The first surface on any way out is left from inside or entered from outside. A grazing hit says little:
  // then another way is asked; none of them lies along an axis or a diagonal.
  static const std::array<Vec3, 4> kWays{
      Vec3(0.5381, 0.6143, 0.5771).normalized(), Vec3(-0.7013, 0.3571, 0.6171).normalized(),
      Vec3(0.3319, -0.8231, 0.4613).normalized(), Vec3(0.2711, 0.4337, -0.8591).normalized()};
  bool answer = false;
  for (const Vec3& way : kWays) {
    const auto hit = first_hit(p, way);
    if (!hit) return false;
    const double closing = hit->normal.dot(way);
    answer = closing > 0;
    if (std::abs(closing) > 1e-3) break;
  }
  return answer;
}

double RayCaster::length_inside(const Vec3& a, const Vec3& b) const {
  const double length = (b - a).norm();
  if (!(length > 0)) return 0;
  const std::vector<Crossing> crossings = scene_->all_crossings(a, (b - a) / length);
  // Which way each crossing goes says what lies behind it, so a ray through an edge that names both triangles
  // counts nothing twice.
  double inside_mm = 0;
  for (size_t i = 0; i + 1 < crossings.size(); ++i) {
    if (!crossings[i].is_entering) continue;
    const double from = std::clamp(crossings[i].t, 0.0, length);
    const double to = std::clamp(crossings[i + 1].t, 0.0, length);
    inside_mm += to - from;
  }
  return inside_mm;
}

}  // namespace tetragauge
