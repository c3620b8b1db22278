// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/solid_from_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/geometry/face_list_file.hpp"
#include "host/solid/close_mesh.hpp"
#include "host/solid/face_order.hpp"
#include "host/solid/group_facets.hpp"

namespace tetragauge {
namespace {

// Planes of one surface may lean this much against one another, for a small one's direction is less sure.
constexpr double kSameWay = 0.9998;  // cosine of 20 mrad

Face face_of(const ClosedMesh& mesh, const FacetGroup& group) {
  Face face;
  Vec3 moment = Vec3::Zero();
  for (const uint32_t i : group.triangles) {
    const auto& t = mesh.triangles[i];
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double area = 0.5 * (b - a).cross(c - a).norm();
    face.area_mm2 += area;
    moment += area * (a + b + c) / 3;
  }
  face.point_mm =
      face.area_mm2 > 0 ? Vec3(moment / face.area_mm2) : mesh.vertices[mesh.triangles[group.triangles[0]][0]];
  face.type = group.is_plane ? SurfaceType::plane : SurfaceType::other;
  if (group.is_plane) {
    face.normal = group.normal;
    face.d_mm = group.d_mm;
  }
  return face;
}

bool is_on_plane(const ClosedMesh& mesh, const FacetGroup& group, const FacetGroup& plane,
                 double off_plane_mm) {
  for (const uint32_t i : group.triangles) {
    for (const uint32_t v : mesh.triangles[i]) {
      if (std::abs(plane.normal.dot(mesh.vertices[v]) - plane.d_mm) > off_plane_mm) return false;
    }
  }
  return true;
}

void add_neighbours(const ClosedMesh& mesh, const std::vector<uint32_t>& face_of_triangle,
                    std::vector<Face>& faces) {
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const uint32_t j : mesh.neighbour[i]) {
      if (j == kNoTriangle || face_of_triangle[i] == face_of_triangle[j]) continue;
      faces[face_of_triangle[i]].neighbours.push_back(static_cast<int>(face_of_triangle[j]) + 1);
    }
  }
  for (Face& face : faces) {
    std::sort(face.neighbours.begin(), face.neighbours.end());
    face.neighbours.erase(std::unique(face.neighbours.begin(), face.neighbours.end()), face.neighbours.end());
  }
}

void add_mass_properties(Solid& solid) {
  solid.box_min_mm = solid.box_max_mm = solid.vertices[0];
  for (const Vec3& p : solid.vertices) {
    solid.box_min_mm = solid.box_min_mm.cwiseMin(p);
    solid.box_max_mm = solid.box_max_mm.cwiseMax(p);
  }
  // About the middle, so that a part far from the origin loses no digits.
  const Vec3 middle = 0.5 * (solid.box_min_mm + solid.box_max_mm);
  Vec3 moment = Vec3::Zero();
  for (const auto& t : solid.triangles) {
    const Vec3 a = solid.vertices[t[0]] - middle, b = solid.vertices[t[1]] - middle,
               c = solid.vertices[t[2]] - middle;
    const double volume = a.dot(b.cross(c)) / 6;
    solid.volume_mm3 += volume;
    moment += volume * (a + b + c) / 4;
  }
  solid.centroid_mm = middle + moment / solid.volume_mm3;
  for (const Face& face : solid.faces()) solid.area_mm2 += face.area_mm2;
}

}  // namespace

Result<Solid> solid_from_mesh(TriangleMesh file, const std::string& place, const ReadSolidOptions& options) {
  double scale = options.unit_scale_mm.value_or(1.0);
  if (!file.declared_unit.empty()) {
    const Result<double> declared = unit_mm(file.declared_unit);
    if (!declared) return bad_input(place + ": " + declared.error().message);
    scale = *declared;
  }
  for (Vec3& p : file.vertices) p *= scale;
  Result<ClosedMesh> mesh = close_mesh(file, place);
  if (!mesh) return mesh.error();
  const FacetGroups grouped = group_facets(*mesh, !options.keep_facets);

  std::vector<Face> faces;
  std::vector<FaceKey> keys;
  for (const FacetGroup& group : grouped.groups) {
    faces.push_back(face_of(*mesh, group));
    keys.push_back(canonical_key(faces.back()));
  }
  std::vector<size_t> order(faces.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return keys[a] < keys[b]; });

  Solid solid;
  std::vector<uint32_t> face_of_triangle(mesh->triangles.size());
  for (const size_t group : order) {
    Face& face = solid.list.faces.emplace_back(faces[group]);
    face.id = static_cast<int>(solid.list.faces.size());
    for (const uint32_t i : grouped.groups[group].triangles) {
      face_of_triangle[i] = static_cast<uint32_t>(face.id) - 1;
      solid.triangles.push_back(mesh->triangles[i]);
      solid.triangle_face.push_back(face_of_triangle[i]);
    }
  }
  add_neighbours(*mesh, face_of_triangle, solid.list.faces);
  number_surfaces(solid.list.faces, [&](const Face& a, const Face& b) {
    if (a.type != SurfaceType::plane || b.type != SurfaceType::plane || a.normal.dot(b.normal) < kSameWay)
      return false;
    const FacetGroup& one = grouped.groups[order[static_cast<size_t>(a.id) - 1]];
    const FacetGroup& other = grouped.groups[order[static_cast<size_t>(b.id) - 1]];
    return a.area_mm2 >= b.area_mm2 ? is_on_plane(*mesh, other, one, grouped.off_plane_mm)
                                    : is_on_plane(*mesh, one, other, grouped.off_plane_mm);
  });
  solid.vertices = std::move(mesh->vertices);
  solid.solids = mesh->bodies;
  solid.declared_unit = file.declared_unit;
  solid.warnings = std::move(mesh->warnings);
  add_mass_properties(solid);
  return solid;
}

}  // namespace tetragauge
