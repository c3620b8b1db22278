// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/ray_caster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/solid/curved_faces.hpp"
#include "host/solid/order_crossings.hpp"
#include "host/solid/shoot_ray.hpp"
#include "host/solid/surface_crossings.hpp"

namespace tetragauge {
namespace {

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

struct Device {
  RTCDevice handle = rtcNewDevice(nullptr);
  ~Device() { rtcReleaseDevice(handle); }
};

}  // namespace

struct RayCaster::Scene {
  Solid solid;
  Device device;
  RTCScene triangles;
  Vec3 centre, half;  // the box, widened
  double diagonal_mm;
  CurvedFaces curved;
  std::vector<char> is_solved;    // by face: curved, and its crossings known from its equation
  std::vector<char> has_surface;  // by triangle: of a free-form face whose surface is known

  explicit Scene(const Solid& model)
      : solid(model),
        triangles(rtcNewScene(device.handle)),
        centre(0.5 * (model.box_min_mm + model.box_max_mm)),
        half(0.5 * (model.box_max_mm - model.box_min_mm)),
        diagonal_mm(std::max(2 * half.norm(), 1e-6)),
        curved(device.handle, solid, centre) {
    half += Vec3::Constant(1e-3 * diagonal_mm);
    find_curved();
    rtcSetSceneFlags(triangles, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST |
                                                           RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    // Spatial splits of the high quality would report a triangle twice.
    rtcSetSceneBuildQuality(triangles, RTC_BUILD_QUALITY_MEDIUM);
    const RTCGeometry geometry = rtcNewGeometry(device.handle, RTC_GEOMETRY_TYPE_TRIANGLE);
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
  ~Scene() { rtcReleaseScene(triangles); }

  void find_curved() {
    for (const Face& face : solid.faces())
      is_solved.push_back(has_crossings(face) && face.type != SurfaceType::plane);
    has_surface.resize(solid.triangles.size());
    for (const TriangleOnSurface& on : solid.on_surface) has_surface[on.triangle] = 1;
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

  const Face& face_of(uint32_t triangle) const { return solid.faces()[solid.triangle_face[triangle]]; }

  Vec3 triangle_normal(uint32_t triangle) const {
    const auto& t = solid.triangles[triangle];
    const Vec3& p = solid.vertices[t[0]];
    return (solid.vertices[t[1]] - p).cross(solid.vertices[t[2]] - p);
  }

  // The crossing with the face of a triangle that Embree named: on the plane of a plane face, otherwise on
  // the triangle itself. nullopt for a triangle seen edge-on.
  std::optional<Crossing> crossing_at(const Vec3& origin, const Vec3& direction, uint32_t triangle) const {
    const Face& face = face_of(triangle);
    const bool is_plane = face.type == SurfaceType::plane;
    const Vec3 normal = is_plane ? face.normal : triangle_normal(triangle);
    const double closing = normal.dot(direction);
    if (closing == 0) return std::nullopt;
    const Vec3& corner = solid.vertices[solid.triangles[triangle][0]];
    const double t =
        is_plane ? (face.d_mm - normal.dot(origin)) / closing : normal.dot(corner - origin) / closing;
    return Crossing{t, triangle, closing < 0, Vec3::Zero()};
  }

  bool is_curved(uint32_t triangle) const {
    return is_solved[solid.triangle_face[triangle]] || has_surface[triangle];
  }

  // A line so flat that it has its crossing further off than the triangle is long meets another triangle
  // there.
  double reach_mm(uint32_t triangle) const {
    const auto& t = solid.triangles[triangle];
    const Vec3 &a = solid.vertices[t[0]], &b = solid.vertices[t[1]], &c = solid.vertices[t[2]];
    return 2 * std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  }

  std::vector<Crossing> curved_crossings(const Vec3& origin, const Vec3& direction,
                                         const std::pair<double, double>& span) const {
    if (curved.is_empty()) return {};
    return curved.crossings(origin, direction, span.first, span.second);
  }

  RayHit hit_of(const Vec3& origin, const Vec3& direction, const Crossing& crossing) const {
    RayHit hit;
    hit.distance_mm = crossing.t;
    hit.point_mm = origin + crossing.t * direction;
    hit.face = static_cast<int>(solid.triangle_face[crossing.triangle]);
    hit.normal = surface_normal(face_of(crossing.triangle), hit.point_mm);
    if (hit.normal.isZero()) hit.normal = crossing.normal;
    if (hit.normal.isZero()) hit.normal = triangle_normal(crossing.triangle).normalized();
    return hit;
  }

  struct TriangleHit {
    double t = 0;  // from the start
    uint32_t triangle = 0;
  };
  std::optional<TriangleHit> closest(const Vec3& start, const Vec3& direction, double near,
                                     double far) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query = ray_query(start, direction, near, far);
    rtcIntersect1(triangles, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return TriangleHit{static_cast<double>(query.ray.tfar), query.hit.primID};
  }

  std::optional<Crossing> first_crossing(const Vec3& origin, const Vec3& direction, double from_mm) const {
    const auto span = clip(origin, direction);
    if (!span || span->second < from_mm) return std::nullopt;
    // From outside the box nothing can be left before it was entered. Where it seems so, the ray came in
    // within a chord's height of a rim, through a plane face's corner that its triangles do not cover.
    const bool starts_outside = span->first > from_mm;
    const auto counts = [&](const Crossing& crossing) {
      return crossing.t > from_mm && (crossing.is_entering || !starts_outside);
    };
    const double rounding = kFloatShare * diagonal_mm;
    const double start = std::max(span->first, from_mm - 100 * rounding);
    const Vec3 query_start = origin + start * direction - centre;
    if (span->second <= start) return std::nullopt;
    std::optional<TriangleHit> next = closest(query_start, direction, 0, span->second - start);
    // What lies beyond a plane face does not matter. A triangle of a curved face may stand for a crossing
    // further on.
    double end = span->second;
    if (next && face_of(next->triangle).type == SurfaceType::plane) {
      const auto hit = crossing_at(origin, direction, next->triangle);
      if (hit && counts(*hit)) end = std::min(end, hit->t + rounding);
    }
    const std::vector<Crossing> known = curved_crossings(origin, direction, {span->first, end});
    if (!next && known.empty()) return std::nullopt;
    const auto best = std::find_if(known.begin(), known.end(), counts);
    const auto hit = next ? crossing_at(origin, direction, next->triangle) : std::nullopt;
    if (hit && counts(*hit)) {
      const bool is_first = best == known.end() || best->t > hit->t;
      if (!is_curved(hit->triangle)) {
        if (is_first) return hit;
      } else if (best != known.end() && best->is_entering == hit->is_entering &&
                 solid.triangle_face[best->triangle] == solid.triangle_face[hit->triangle] &&
                 std::abs(best->t - hit->t) <= reach_mm(hit->triangle)) {
        return *best;
      }
    }
    // A ray that grazes, or comes by an edge.
    for (const Crossing& crossing : all_crossings(origin, direction)) {
      if (counts(crossing)) return crossing;
    }
    return std::nullopt;
  }

  // Every crossing of the whole line, ascending, in and out by turns.
  std::vector<Crossing> all_crossings(const Vec3& origin, const Vec3& direction) const {
    const auto span = clip(origin, direction);
    if (!span) return {};
    std::vector<uint32_t> candidates;
    GatheringContext gathering{{}, &candidates};
    rtcInitIntersectContext(&gathering.context);
    gathering.context.filter = gather_hit;
    RTCRayHit query =
        ray_query(origin + span->first * direction - centre, direction, 0, span->second - span->first);
    rtcIntersect1(triangles, &gathering.context, &query);
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    std::vector<TriangleCrossing> hits;
    for (const uint32_t triangle : candidates) {
      const auto hit = crossing_at(origin, direction, triangle);
      if (hit) {
        hits.push_back(
            {*hit, is_curved(triangle), is_flat(triangle_normal(triangle), direction), reach_mm(triangle)});
      }
    }
    return order_crossings(solid, std::move(hits), curved_crossings(origin, direction, *span),
                           kFloatShare * diagonal_mm);
  }
};

RayCaster::RayCaster(const Solid& solid) : scene_(std::make_unique<Scene>(solid)) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

std::optional<RayHit> RayCaster::first_hit(const Vec3& origin, const Vec3& direction, double from_mm) const {
  const auto crossing = scene_->first_crossing(origin, direction, from_mm);
  if (!crossing) return std::nullopt;
  return scene_->hit_of(origin, direction, *crossing);
}

bool RayCaster::occluded(const Vec3& a, const Vec3& b, double clearance_mm) const {
  const double length = (b - a).norm();
  if (!(length > 2 * clearance_mm)) return false;
  const auto hit = scene_->first_crossing(a, (b - a) / length, clearance_mm);
  return hit && hit->t < length - clearance_mm;
}

bool RayCaster::inside(const Vec3& p) const {
  // The first surface on any way out is left from inside or entered from outside. A grazing hit says little:
  // then another way is asked; none of them lies along an axis or a diagonal.
  static const std::array<Vec3, 4> kWays{
      Vec3(0.5381, 0.6143, 0.5771).normalized(), Vec3(-0.7013, 0.3571, 0.6171).normalized(),
      Vec3(0.3319, -0.8231, 0.4613).normalized(), Vec3(0.2711, 0.4337, -0.8591).normalized()};
  bool is_inside = false;
  for (const Vec3& way : kWays) {
    const auto hit = first_hit(p, way);
    if (!hit) return false;
    const double closing = hit->normal.dot(way);
    is_inside = closing > 0;
    if (std::abs(closing) > 1e-3) break;
  }
  return is_inside;
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
