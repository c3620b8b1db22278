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

// Faces on one surface as exporters, Booleans and six-digit matrices leave them: directions agree to this
// angle, places to this distance at the faces themselves.
constexpr double kSameAngle_rad = 5e-6;
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

bool is_same_surface(const DescribedFace& one, const DescribedFace& other) {
  const Face &a = one.face, &b = other.face;
  if (a.type != b.type || a.concave != b.concave) return false;
  const auto is_same_length = [](double x, double y) { return std::abs(x - y) < kSamePlace_mm; };
  switch (a.type) {
    case SurfaceType::plane:
      return is_same_direction(a.normal, b.normal) && is_same_length(a.normal.dot(b.point_mm), a.d_mm) &&
             is_same_length(b.normal.dot(a.point_mm), b.d_mm);
    case SurfaceType::cylinder:
      return is_same_direction(a.axis, b.axis) && is_same_length(a.radius_mm, b.radius_mm) &&
             distance_to_axis(a, b.point_on_axis_mm) < kSamePlace_mm;
    case SurfaceType::cone: {
      const double along = a.axis.dot(b.point_on_axis_mm - a.point_on_axis_mm);
      return is_same_direction(a.axis, b.axis) &&
             std::abs(a.half_angle_rad - b.half_angle_rad) < kSameAngle_rad &&
             distance_to_axis(a, b.point_on_axis_mm) < kSamePlace_mm &&
             is_same_length(a.radius_mm + along * std::tan(a.half_angle_rad), b.radius_mm);
    }
    case SurfaceType::sphere:
      return is_same_length(a.radius_mm, b.radius_mm) &&
             (a.point_on_axis_mm - b.point_on_axis_mm).norm() < kSamePlace_mm;
    case SurfaceType::torus:
      return is_same_direction(a.axis, b.axis) && is_same_length(a.radius_mm, b.radius_mm) &&
             is_same_length(one.minor_radius_mm, other.minor_radius_mm) &&
             (a.point_on_axis_mm - b.point_on_axis_mm).norm() < kSamePlace_mm;
    case SurfaceType::other:
      return false;
  }
  return false;
}

struct Merged {
  DescribedFace described;
  std::vector<TopoDS_Face> patches;
  std::vector<size_t> neighbours;  // groups
  Key key{};
};

// The largest patch gives the equation, all of them area and centroid.
Merged merge(const std::vector<size_t>& members, const std::vector<DescribedFace>& described,
             const TopTools_IndexedMapOfShape& shapes) {
  size_t largest = members[0];
  double area = 0;
  Vec3 moment = Vec3::Zero();
  Merged merged;
  for (const size_t member : members) {
    const Face& face = described[member].face;
    area += face.area_mm2;
    moment += face.area_mm2 * face.point_mm;
    // Ties by place: which patch the file names first must not matter.
    const Key key = canonical_key(face), best = canonical_key(described[largest].face);
    const double gain = face.area_mm2 - described[largest].face.area_mm2;
    if (gain > kLengthStep_mm || (gain > -kLengthStep_mm && key < best)) largest = member;
    merged.patches.push_back(TopoDS::Face(shapes(static_cast<int>(member) + 1)));
  }
  merged.described = described[largest];
  Face& face = merged.described.face;
  face.area_mm2 = area;
  if (members.size() > 1) {
    face.point_mm = moment / area;
    if (face.type == SurfaceType::cylinder || face.type == SurfaceType::cone) {
      const double along = face.axis.dot(face.point_mm - face.point_on_axis_mm);
      face.point_on_axis_mm += along * face.axis;
      face.radius_mm += along * std::tan(face.half_angle_rad);
    }
  }
  merged.key = canonical_key(face);
  return merged;
}

void number_surfaces(const std::vector<const Merged*>& order, std::vector<Face>& faces) {
  int surfaces = 0;
  for (size_t i = 0; i < faces.size(); ++i) {
    for (size_t j = 0; j < i && faces[i].surface == 0; ++j) {
      if (is_same_surface(order[j]->described, order[i]->described)) faces[i].surface = faces[j].surface;
    }
    if (faces[i].surface == 0) faces[i].surface = ++surfaces;
  }
}

size_t root(std::vector<size_t>& parent, size_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
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
  std::vector<DescribedFace> described;
  for (int i = 1; i <= shapes.Extent(); ++i) described.push_back(describe_surface(TopoDS::Face(shapes(i))));

  std::vector<std::pair<size_t, size_t>> touching;
  for (int e = 1; e <= faces_of_edge.Extent(); ++e) {
    for (const TopoDS_Shape& a : faces_of_edge(e)) {
      for (const TopoDS_Shape& b : faces_of_edge(e)) {
        const size_t i = static_cast<size_t>(shapes.FindIndex(a)) - 1;
        const size_t j = static_cast<size_t>(shapes.FindIndex(b)) - 1;
        if (i != j) touching.emplace_back(i, j);
      }
    }
  }
  std::vector<size_t> parent(count);
  std::iota(parent.begin(), parent.end(), size_t{0});
  for (const auto& [i, j] : touching) {
    if (is_same_surface(described[i], described[j])) parent[root(parent, i)] = root(parent, j);
  }
  std::vector<std::vector<size_t>> members(count);
  for (size_t i = 0; i < count; ++i) members[root(parent, i)].push_back(i);

  std::vector<Merged> groups(count);  // at the roots; the others stay empty
  std::vector<const Merged*> order;
  for (size_t i = 0; i < count; ++i) {
    if (members[i].empty()) continue;
    groups[i] = merge(members[i], described, shapes);
    order.push_back(&groups[i]);
  }
  for (const auto& [i, j] : touching) {
    const size_t a = root(parent, i), b = root(parent, j);
    if (a != b) groups[a].neighbours.push_back(b);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Merged* a, const Merged* b) { return a->key < b->key; });

  ListedFaces listed;
  std::vector<int> id_of_group(count);
  for (size_t k = 0; k < order.size(); ++k) {
    Face& face = listed.list.faces.emplace_back(order[k]->described.face);
    face.id = static_cast<int>(k) + 1;
    id_of_group[static_cast<size_t>(order[k] - groups.data())] = face.id;
    listed.patches.push_back(order[k]->patches);
  }
  for (size_t k = 0; k < order.size(); ++k) {
    std::vector<int>& ids = listed.list.faces[k].neighbours;
    for (const size_t group : order[k]->neighbours) ids.push_back(id_of_group[group]);
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  }
  number_surfaces(order, listed.list.faces);
  return listed;
}

}  // namespace tetragauge
