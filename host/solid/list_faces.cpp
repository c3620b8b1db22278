// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/list_faces.hpp"

#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/solid/describe_surface.hpp"
#include "host/solid/face_order.hpp"

namespace tetragauge {
namespace {

// Areas closer than this are equal: far above rounding.
constexpr double kEqualArea_mm2 = 1e-4;

struct Merged {
  Face described;
  std::vector<TopoDS_Face> patches;
  std::vector<size_t> neighbours;  // groups
  FaceKey key{};
};

// The largest patch gives the equation, all of them area and centroid.
Merged merge(const std::vector<size_t>& members, const std::vector<Face>& described,
             const TopTools_IndexedMapOfShape& shapes) {
  size_t largest = members[0];
  double area = 0;
  Vec3 moment = Vec3::Zero();
  Merged merged;
  for (const size_t member : members) {
    const Face& face = described[member];
    area += face.area_mm2;
    moment += face.area_mm2 * face.point_mm;
    // Ties by place: which patch the file names first must not matter.
    const FaceKey key = canonical_key(face), best = canonical_key(described[largest]);
    const double gain = face.area_mm2 - described[largest].area_mm2;
    if (gain > kEqualArea_mm2 || (gain > -kEqualArea_mm2 && key < best)) largest = member;
    merged.patches.push_back(TopoDS::Face(shapes(static_cast<int>(member) + 1)));
  }
  merged.described = described[largest];
  Face& face = merged.described;
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
  std::vector<Face> described;
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
    Face& face = listed.list.faces.emplace_back(order[k]->described);
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
  number_surfaces(listed.list.faces, is_same_surface);
  return listed;
}

}  // namespace tetragauge
