// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/curved_faces.hpp"

#include <algorithm>
#include <cmath>

#include "host/solid/shoot_ray.hpp"
#include "host/solid/surface_crossings.hpp"

namespace tetragauge {
namespace {

bool is_solved(const Face& face) {
  return has_crossings(face) && face.type != SurfaceType::plane;
}

using Corners = std::array<Vec3, 3>;

Corners corners_of(const Solid& solid, uint32_t triangle) {
  const auto& t = solid.triangles[triangle];
  return {solid.vertices[t[0]], solid.vertices[t[1]], solid.vertices[t[2]]};
}

// Twice the largest height of the surface over the triangle, taken at the middles of edges and face.
double height_over(const Face& face, const Corners& p) {
  double height = std::abs(distance_to_surface(face, (p[0] + p[1] + p[2]) / 3));
  for (size_t k = 0; k < 3; ++k) {
    height = std::max(height, std::abs(distance_to_surface(face, 0.5 * (p[k] + p[(k + 1) % 3]))));
  }
  return 2 * height;
}

// Newton's steps from two neighbouring triangles find one point but for this: far more than rounding. Who
// takes it twice counts it once.
constexpr double kSamePoint_mm = 1e-7;

// Whether the line through x along n meets the triangle, its edges included, or passes it by `slack_mm`.
bool is_over(const Corners& p, const Vec3& x, const Vec3& n, double slack_mm = 0) {
  for (size_t k = 0; k < 3; ++k) {
    const Vec3& q = p[(k + 1) % 3];
    const double least = slack_mm > 0 ? -slack_mm * (q - p[k]).norm() : 0;
    if (n.dot((p[k] - x).cross(q - x)) < least) return false;
  }
  return true;
}

bool is_in_box(const std::array<float, 6>& box, const Vec3& p) {
  return p.x() >= box[0] && p.x() <= box[3] && p.y() >= box[1] && p.y() <= box[4] && p.z() >= box[2] &&
         p.z() <= box[5];
}

struct BoxContext {
  RTCIntersectContext context;  // first, so that Embree's pointer to it is a pointer to this
  std::vector<uint32_t>* found;
};

void box_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto* boxes = static_cast<const std::array<float, 6>*>(arguments->geometryUserPtr);
  const std::array<float, 6>& box = boxes[arguments->primID];
  *arguments->bounds_o = {box[0], box[1], box[2], 0, box[3], box[4], box[5], 0};
}

void box_hit(const RTCIntersectFunctionNArguments* arguments) {
  if (!arguments->valid[0]) return;
  reinterpret_cast<const BoxContext*>(arguments->context)->found->push_back(arguments->primID);
}

}  // namespace

CurvedFaces::CurvedFaces(RTCDevice device, const Solid& solid, const Vec3& centre)
    : solid_(solid), centre_(centre) {
  for (uint32_t i = 0; i < solid.triangles.size(); ++i) {
    if (is_solved(solid.faces()[solid.triangle_face[i]])) triangles_.push_back(i);
  }
  std::stable_sort(triangles_.begin(), triangles_.end(),
                   [&](uint32_t a, uint32_t b) { return solid.triangle_face[a] < solid.triangle_face[b]; });
  for (const uint32_t triangle : triangles_)
    add_box(triangle, height_over(solid.faces()[solid.triangle_face[triangle]], corners_of(solid, triangle)));
  for (const TriangleOnSurface& on : solid.on_surface) {
    FreeformPiece piece{corners_of(solid, on.triangle), solid.surfaces[on.surface].get(), on.corners};
    piece.height_mm = freeform_height_mm(piece);
    triangles_.push_back(on.triangle);
    add_box(on.triangle, piece.height_mm);
    pieces_.push_back(piece);
  }
  if (triangles_.empty()) return;
  scene_ = rtcNewScene(device);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(boxes_.size()));
  rtcSetGeometryUserData(geometry, boxes_.data());
  rtcSetGeometryBoundsFunction(
      geometry, [](const RTCBoundsFunctionArguments* arguments) { box_bounds(arguments); }, nullptr);
  rtcSetGeometryIntersectFunction(geometry, box_hit);
  commit_scene(scene_, geometry);
}

void CurvedFaces::add_box(uint32_t triangle, double height_mm) {
  const double margin = height_mm + kFloatShare * (solid_.box_max_mm - solid_.box_min_mm).norm();
  const Corners p = corners_of(solid_, triangle);
  const Vec3 low = p[0].cwiseMin(p[1]).cwiseMin(p[2]) - centre_ - Vec3::Constant(margin);
  const Vec3 high = p[0].cwiseMax(p[1]).cwiseMax(p[2]) - centre_ + Vec3::Constant(margin);
  std::array<float, 6> box;
  for (int i = 0; i < 3; ++i) {
    box[static_cast<size_t>(i)] = static_cast<float>(low[i]);
    box[static_cast<size_t>(i) + 3] = static_cast<float>(high[i]);
  }
  boxes_.push_back(box);
}

CurvedFaces::~CurvedFaces() {
  if (scene_) rtcReleaseScene(scene_);
}

std::vector<Crossing> CurvedFaces::crossings(const Vec3& origin, const Vec3& direction, double start,
                                             double end) const {
  std::vector<uint32_t> found;
  BoxContext context{{}, &found};
  rtcInitIntersectContext(&context.context);
  RTCRayHit query = ray_query(origin + start * direction - centre_, direction, 0, end - start);
  rtcIntersect1(scene_, &context.context, &query);
  std::sort(found.begin(), found.end());  // by face, whatever the way through the tree
  found.erase(std::unique(found.begin(), found.end()), found.end());

  std::vector<Crossing> result;
  uint32_t face_index = 0;
  bool is_first = true;
  SurfaceCrossings roots;
  // The line is solved from near the part, so that a far origin costs no digits.
  const double near_t = (centre_ - origin).dot(direction);
  const Vec3 near = origin + near_t * direction;
  std::array<Vec3, 4> points, normals;
  std::array<bool, 4> is_taken{};
  for (const uint32_t candidate : found) {
    const uint32_t triangle = triangles_[candidate];
    if (candidate >= first_piece()) {
      const FreeformPiece& piece = pieces_[candidate - first_piece()];
      const FreeformCrossings own = freeform_crossings(piece, near, direction);
      for (size_t k = 0; k < own.count; ++k) {
        const FreeformCrossing& crossing = own.crossings[k];
        const double t = near_t + crossing.s;
        if (t < start || t > end ||
            !is_over(piece.corners, crossing.point_mm, crossing.normal, kSamePoint_mm))
          continue;
        result.push_back({t, triangle, crossing.normal.dot(direction) < 0, crossing.normal});
      }
      continue;
    }
    const uint32_t own = solid_.triangle_face[triangle];
    const Face& face = solid_.faces()[own];
    if (is_first || own != face_index) {
      is_first = false;
      face_index = own;
      roots = surface_crossings(face, near, direction);
      is_taken = {};
      for (size_t k = 0; k < roots.count; ++k) {
        points[k] = near + roots.s[k] * direction;
        normals[k] = surface_normal(face, points[k]);
      }
    }
    for (size_t k = 0; k < roots.count; ++k) {
      const double t = near_t + roots.s[k];
      if (is_taken[k] || t < start || t > end) continue;
      if (!is_in_box(boxes_[candidate], points[k] - centre_)) continue;
      if (!is_over(corners_of(solid_, triangle), points[k], normals[k])) continue;
      is_taken[k] = true;
      result.push_back({t, triangle, roots.is_entering[k], Vec3::Zero()});
    }
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  return result;
}

}  // namespace tetragauge
