// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/tessellate.hpp"

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Poly_Triangulation.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS_Compound.hxx>
#include <algorithm>
#include <numeric>

#include "host/solid/close_pinches.hpp"
#include "host/solid/kernel_surface.hpp"
#include "host/solid/surface_crossings.hpp"

namespace tetragauge {
namespace {

// Small radii get at least 18 chords a turn, whatever the deviation allows: ray candidates need a shape.
constexpr double kAngularDeflection_rad = 0.35;

constexpr uint32_t kNoSurface = 0xFFFFFFFFu;

struct Triangle {
  std::array<Vec3, 3> corners;
  uint32_t face;
  uint32_t surface;  // of a free-form face
  std::array<SurfaceParameters, 3> parameters{};
};

bool less(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

// Appends the triangles of one patch; false if it has none.
bool add_triangles(const TopoDS_Face& shape, uint32_t face, uint32_t surface,
                   std::vector<Triangle>& triangles) {
  TopLoc_Location location;
  const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(shape, location);
  if (mesh.IsNull() || mesh->NbTriangles() == 0) return false;
  const gp_Trsf& T = location.Transformation();
  const bool is_reversed = (shape.Orientation() == TopAbs_REVERSED) != T.IsNegative();
  for (int i = 1; i <= mesh->NbTriangles(); ++i) {
    int a = 0, b = 0, c = 0;
    mesh->Triangle(i).Get(a, b, c);
    if (is_reversed) std::swap(b, c);
    Triangle triangle{{}, face, mesh->HasUVNodes() ? surface : kNoSurface};
    size_t k = 0;
    for (const int node : {a, b, c}) {
      const gp_Pnt p = mesh->Node(node).Transformed(T);
      if (triangle.surface != kNoSurface) {
        const gp_Pnt2d uv = mesh->UVNode(node);
        triangle.parameters[k] = {uv.X(), uv.Y()};
      }
      triangle.corners[k++] = Vec3(p.X(), p.Y(), p.Z());
    }
    // Each triangle begins at its least corner, so that equal triangles have equal bytes.
    const auto least = std::min_element(triangle.corners.begin(), triangle.corners.end(), less);
    std::rotate(triangle.parameters.begin(), triangle.parameters.begin() + (least - triangle.corners.begin()),
                triangle.parameters.end());
    std::rotate(triangle.corners.begin(), least, triangle.corners.end());
    triangles.push_back(triangle);
  }
  return true;
}

bool is_before(const Triangle& a, const Triangle& b) {
  if (a.face != b.face) return a.face < b.face;
  return std::lexicographical_compare(a.corners.begin(), a.corners.end(), b.corners.begin(), b.corners.end(),
                                      less);
}

// Corners that two faces hold of one point of their common edge differ by rounding at most.
constexpr double kWeld_mm = 1e-7;

// Where triangles do not close, vertices may move by this share of the chordal deviation.
constexpr double kPinchShare = 0.25;

// Numbers the corners: index of the representative for each.
std::vector<uint32_t> weld(const std::vector<Vec3>& corners, std::vector<Vec3>& vertices) {
  std::vector<size_t> order(corners.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return less(corners[a], corners[b]); });
  std::vector<uint32_t> index(corners.size());
  vertices.clear();
  for (const size_t i : order) {
    const Vec3& p = corners[i];
    // Candidates lie at the end of the sorted list, within the weld distance in x.
    bool is_known = false;
    for (size_t j = vertices.size(); j-- > 0 && p.x() - vertices[j].x() <= kWeld_mm;) {
      if ((p - vertices[j]).cwiseAbs().maxCoeff() > kWeld_mm) continue;
      index[i] = static_cast<uint32_t>(j);
      is_known = true;
      break;
    }
    if (is_known) continue;
    index[i] = static_cast<uint32_t>(vertices.size());
    vertices.push_back(p);
  }
  return index;
}

using Indices = std::array<uint32_t, 3>;

std::vector<Indices> triangles_of(const std::vector<uint32_t>& index) {
  std::vector<Indices> result;
  for (size_t i = 0; i < index.size(); i += 3) result.push_back({index[i], index[i + 1], index[i + 2]});
  return result;
}

}  // namespace

Tessellation tessellate(const ListedFaces& faces, double chordal_deviation_mm) {
  BRep_Builder builder;
  TopoDS_Compound all;
  builder.MakeCompound(all);
  for (const std::vector<TopoDS_Face>& patches : faces.patches) {
    for (const TopoDS_Face& patch : patches) builder.Add(all, patch);
  }
  BRepTools::Clean(all);
  const BRepMesh_IncrementalMesh mesh(all, chordal_deviation_mm, false, kAngularDeflection_rad, false);

  Tessellation result;
  std::vector<Triangle> triangles;
  for (size_t i = 0; i < faces.patches.size(); ++i) {
    for (const TopoDS_Face& patch : faces.patches[i]) {
      uint32_t surface = kNoSurface;
      if (!has_crossings(faces.list.faces[i])) {
        surface = static_cast<uint32_t>(result.surfaces.size());
        result.surfaces.push_back(kernel_surface(patch));
      }
      result.is_complete &= add_triangles(patch, static_cast<uint32_t>(i), surface, triangles);
    }
  }
  std::stable_sort(triangles.begin(), triangles.end(), is_before);
  std::vector<Vec3> corners;
  for (const Triangle& t : triangles) corners.insert(corners.end(), t.corners.begin(), t.corners.end());
  std::vector<Indices> indices = triangles_of(weld(corners, result.vertices));
  result.is_closed = is_closed(indices);
  if (!result.is_closed) {
    const std::vector<uint32_t> vertex =
        close_pinches(result.vertices, indices, kPinchShare * chordal_deviation_mm);
    result.is_closed = !vertex.empty();
    for (Indices& t : indices) {
      for (uint32_t& v : t) v = vertex.empty() ? v : vertex[v];
    }
  }
  for (size_t i = 0; i < triangles.size(); ++i) {
    const Indices& t = indices[i];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    if (triangles[i].surface != kNoSurface) {
      result.on_surface.push_back(
          {static_cast<uint32_t>(result.triangles.size()), triangles[i].surface, triangles[i].parameters});
    }
    result.triangles.push_back(t);
    result.triangle_face.push_back(triangles[i].face);
  }
  return result;
}

}  // namespace tetragauge
