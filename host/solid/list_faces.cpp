// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/list_faces.hpp"

#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "host/solid/describe_surface.hpp"

namespace tetragauge {
namespace {

// Faces on one surface as two exporters or a Boolean leave them: directions agree to this angle, places to
// this distance at the faces themselves.
constexpr double kSameAngle_rad = 1e-6;
constexpr double kSamePlace_mm = 1e-4;

// Steps of the canonical order: far above rounding, far below what tells two faces apart.
constexpr double kDirectionStep = 1e-5;
constexpr double kLengthStep_mm = 1e-4;

using Key = std::array<int64_t, 13>;

Key canonical_key(const Face& face) {
  const auto direction = [](double x) { return std::llround(x / kDirectionStep); };
  const auto length = [](double x) { return std::llround(x / kLengthStep_mm); };
  const Vec3 way = face.type == SurfaceType::plane ? face.normal : face.axis;
  // A point on an axis slides along it; only the foot of the origin on it is the surface's own.
  const bool has_axis = face.type == SurfaceType::cylinder || face.type == SurfaceType::cone;
  const Vec3 place = has_axis ? Vec3(face.point_on_axis_mm - face.axis * face.axis.dot(face.point_on_axis_mm))
                              : face.point_on_axis_mm;
  return {static_cast<int64_t>(face.type),
          direction(way.x()),
          direction(way.y()),
          direction(way.z()),
          length(face.d_mm),
          length(face.type == SurfaceType::cone ? face.half_angle_rad : face.radius_mm),
          length(place.x()),
          length(place.y()),
          length(place.z()),
          length(face.point_mm.x()),
          length(face.point_mm.y()),
          length(face.point_mm.z()),
          length(face.area_mm2)};
}

bool is_same_direction(const Vec3& a, const Vec3& b) {
  return a.cross(b).norm() < kSameAngle_rad && a.dot(b) > 0;
}

double distance_to_axis(const Face& face, const Vec3& p) {
  return face.axis.cross(p - face.point_on_axis_mm).norm();
}

bool is_same_surface(const Face& a, const Face& b) {
  if (a.type != b.type || a.concave != b.concave) return false;
  switch (a.type) {
    case SurfaceType::plane:
      return is_same_direction(a.normal, b.normal) &&
             std::abs(a.normal.dot(b.point_mm) - a.d_mm) < kSamePlace_mm &&
             std::abs(b.normal.dot(a.point_mm) - b.d_mm) < kSamePlace_mm;
    case SurfaceType::cylinder:
      return is_same_direction(a.axis, b.axis) && std::abs(a.radius_mm - b.radius_mm) < kSamePlace_mm &&
             distance_to_axis(a, b.point_on_axis_mm) < kSamePlace_mm;
    case SurfaceType::cone: {
      const double along = a.axis.dot(b.point_on_axis_mm - a.point_on_axis_mm);
      const double radius_there = a.radius_mm + along * std::tan(a.half_angle_rad);
      return is_same_direction(a.axis, b.axis) &&
             std::abs(a.half_angle_rad - b.half_angle_rad) < kSameAngle_rad &&
             distance_to_axis(a, b.point_on_axis_mm) < kSamePlace_mm &&
             std::abs(radius_there - b.radius_mm) < kSamePlace_mm;
    }
    case SurfaceType::sphere:
      return std::abs(a.radius_mm - b.radius_mm) < kSamePlace_mm &&
             (a.point_on_axis_mm - b.point_on_axis_mm).norm() < kSamePlace_mm;
    case SurfaceType::torus:
    case SurfaceType::other:
      return false;
  }
  return false;
}

void number_surfaces(std::vector<Face>& faces) {
  int surfaces = 0;
  for (size_t i = 0; i < faces.size(); ++i) {
    for (size_t j = 0; j < i && faces[i].surface == 0; ++j) {
      if (is_same_surface(faces[j], faces[i])) faces[i].surface = faces[j].surface;
    }
    if (faces[i].surface == 0) faces[i].surface = ++surfaces;
  }
}

}  // namespace

ListedFaces list_faces(const std::vector<TopoDS_Solid>& solids) {
  TopTools_IndexedMapOfShape shapes;
  TopTools_IndexedDataMapOfShapeListOfShape faces_of_edge;
  for (const TopoDS_Solid& solid : solids) {
    TopExp::MapShapes(solid, TopAbs_FACE, shapes);
    TopExp::MapShapesAndAncestors(solid, TopAbs_EDGE, TopAbs_FACE, faces_of_edge);
  }
  const size_t count = static_cast<size_t>(shapes.Extent());
  std::vector<Face> described;
  std::vector<Key> keys;
  for (int i = 1; i <= shapes.Extent(); ++i) {
    described.push_back(describe_surface(TopoDS::Face(shapes(i))));
    keys.push_back(canonical_key(described.back()));
  }
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return keys[a] < keys[b]; });

  ListedFaces listed;
  std::vector<int> id_of_shape(count + 1);  // by the map's index, which begins at 1
  for (size_t k = 0; k < count; ++k) {
    Face& face = listed.list.faces.emplace_back(std::move(described[order[k]]));
    face.id = static_cast<int>(k) + 1;
    id_of_shape[order[k] + 1] = face.id;
    listed.shapes.push_back(TopoDS::Face(shapes(static_cast<int>(order[k]) + 1)));
  }
  for (int e = 1; e <= faces_of_edge.Extent(); ++e) {
    for (const TopoDS_Shape& a : faces_of_edge(e)) {
      for (const TopoDS_Shape& b : faces_of_edge(e)) {
        const int id = id_of_shape[static_cast<size_t>(shapes.FindIndex(a))];
        const int other = id_of_shape[static_cast<size_t>(shapes.FindIndex(b))];
        if (id != other) listed.list.faces[static_cast<size_t>(id) - 1].neighbours.push_back(other);
      }
    }
  }
  for (Face& face : listed.list.faces) {
    std::sort(face.neighbours.begin(), face.neighbours.end());
    face.neighbours.erase(std::unique(face.neighbours.begin(), face.neighbours.end()), face.neighbours.end());
  }
  number_surfaces(listed.list.faces);
  return listed;
}

}  // namespace tetragauge
