// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/build_csg.hpp"

#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Ax2.hxx>
#include <numbers>

#include "host/base/excerpt.hpp"
#include "host/solid/combine_shapes.hpp"
#include "host/solid/extrude_outline.hpp"
#include "host/solid/polyhedral_solid.hpp"

namespace tetragauge {
namespace {

// As for every number of a call (csg_arguments.cpp).
constexpr double kLargest = 1e15;

constexpr const char* kSupported =
    "group, union, difference, intersection, multmatrix, color, render, cube, cylinder, sphere, polyhedron, "
    "linear_extrude, rotate_extrude";

TopoDS_Shape polyhedral(const CsgNode& node, PolyhedralMesh mesh, const Affine& M) {
  for (Vec3& corner : mesh.corners) corner = M * corner;
  try {
    return polyhedral_solid(std::move(mesh));
  } catch (const PolyhedronFailure& failure) {
    throw CsgFailure(node, node.name + ": " + failure.what());
  }
}

TopoDS_Shape cube(const CsgNode& node, const Affine& M) {
  const std::vector<double> size = vector_argument(node, "size", 3);
  if (!(size[0] > 0) || !(size[1] > 0) || !(size[2] > 0)) {
    throw CsgFailure(node, "cube: 'size' must be above 0");
  }
  const Vec3 extent(size[0], size[1], size[2]);
  const Vec3 low = bool_argument(node, "center", false) ? Vec3(-extent / 2) : Vec3(Vec3::Zero());
  PolyhedralMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.corners.push_back(low + extent.cwiseProduct(Vec3(i & 1, (i >> 1) & 1, i >> 2)));
  }
  for (const CornerLoop& loop : std::vector<CornerLoop>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    mesh.faces.push_back({loop, {}});
  }
  return polyhedral(node, std::move(mesh), M);
}

// Rings of `sides` corners about z, bottom to top, closed by a face or a point at either end.
TopoDS_Shape stacked_rings(const CsgNode& node, const std::vector<std::pair<double, double>>& radius_and_z,
                           size_t sides, const Affine& M) {
  PolyhedralMesh mesh;
  for (const auto& [radius, z] : radius_and_z) {
    for (size_t i = 0; i < sides; ++i) {
      const double phi = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(sides);
      mesh.corners.emplace_back(radius * std::cos(phi), radius * std::sin(phi), z);
    }
  }
  const size_t top = (radius_and_z.size() - 1) * sides;
  PolyhedralFace bottom_face, top_face;
  for (size_t i = 0; i < sides; ++i) {
    bottom_face.outer.push_back(sides - 1 - i);
    top_face.outer.push_back(top + i);
  }
  mesh.faces = {bottom_face, top_face};
  for (size_t ring = 0; ring < top; ring += sides) {
    for (size_t i = 0; i < sides; ++i) {
      const size_t j = (i + 1) % sides;
      mesh.faces.push_back({{ring + i, ring + j, ring + sides + j, ring + sides + i}, {}});
    }
  }
  return polyhedral(node, std::move(mesh), M);
}

const AxialScale& require_axial(const CsgNode& node, const std::optional<AxialScale>& scale) {
  if (!scale) {
    throw CsgFailure(node, node.name +
                               ": a round body under a skew or uneven scale has no exact surface here; scale "
                               "it evenly across its axis, or give it $fn of 3 to 36");
  }
  return *scale;
}

TopoDS_Shape cylinder(const CsgNode& node, const Affine& M) {
  const double height = positive_argument(node, "h");
  const double r1 = number_argument(node, "r1", 0), r2 = number_argument(node, "r2", 0);
  if (r1 < 0 || r2 < 0 || r1 + r2 <= 0) throw CsgFailure(node, "cylinder: 'r1' and 'r2' must be above 0");
  const double bottom = bool_argument(node, "center", false) ? -height / 2 : 0;
  if (const size_t sides = facets(node, std::max(r1, r2))) {
    return stacked_rings(node, {{r1, bottom}, {r2, bottom + height}}, sides, M);
  }
  const std::optional<AxialScale> found = axial_scale(M);
  const AxialScale& scale = require_axial(node, found);
  const gp_Ax2 axes(gp_Pnt(0, 0, bottom * scale.along_z), gp::DZ(), gp::DX());
  const double h = height * scale.along_z;
  const TopoDS_Shape body = r1 == r2 ? BRepPrimAPI_MakeCylinder(axes, r1, h).Shape()
                                     : BRepPrimAPI_MakeCone(axes, r1, r2, h).Shape();
  return moved(body, scale.S);
}

TopoDS_Shape sphere(const CsgNode& node, const Affine& M) {
  const double radius = positive_argument(node, "r");
  if (const size_t sides = facets(node, radius)) {
    // OpenSCAD's rings stand half a step off the poles.
    const size_t rings = (sides + 1) / 2;
    std::vector<std::pair<double, double>> radius_and_z;
    for (size_t i = rings; i-- > 0;) {
      const double phi = std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(rings);
      radius_and_z.emplace_back(radius * std::sin(phi), radius * std::cos(phi));
    }
    return stacked_rings(node, radius_and_z, sides, M);
  }
  const std::optional<gp_Trsf> T = similarity(M);
  if (!T) {
    throw CsgFailure(
        node, "sphere: scaled to an ellipsoid, which has no exact surface here; give it $fn of 3 to 36");
  }
  return moved(BRepPrimAPI_MakeSphere(radius).Shape(), *T);
}

TopoDS_Shape polyhedron(const CsgNode& node, const Affine& M) {
  PolyhedralMesh mesh;
  for (const std::vector<double>& row : rows_argument(node, "points", 3)) {
    mesh.corners.emplace_back(row[0], row[1], row[2]);
  }
  for (std::vector<size_t>& loop : index_lists_argument(node, "faces", mesh.corners.size())) {
    mesh.faces.push_back({std::move(loop), {}});
  }
  return polyhedral(node, std::move(mesh), M);
}

TopoDS_Shape build(const CsgNode& node, const Affine& M) {
  const auto children = [&](const Affine& placement) {
    std::vector<TopoDS_Shape> shapes;
    for (const CsgNode& child : node.children) shapes.push_back(build(child, placement));
    return shapes;
  };
  if (node.name == "cube") return cube(node, M);
  if (node.name == "cylinder") return cylinder(node, M);
  if (node.name == "sphere") return sphere(node, M);
  if (node.name == "polyhedron") return polyhedron(node, M);
  if (node.name == "linear_extrude") return linear_extrude(node, M);
  if (node.name == "rotate_extrude") return rotate_extrude(node, M);
  if (node.name == "multmatrix") {
    const Affine placement = M * matrix_argument(node);
    if (!(placement.A.cwiseAbs().maxCoeff() <= kLargest && placement.t.cwiseAbs().maxCoeff() <= kLargest))
      throw CsgFailure(node,
                       "multmatrix: with those around it it scales or shifts beyond 1e15; check the numbers");
    return unite(node, children(placement));
  }
  if (node.name == "difference") return subtract(node, children(M));
  if (node.name == "intersection") return intersect(node, children(M));
  if (node.name == "group" || node.name == "union" || node.name == "color" || node.name == "render") {
    return unite(node, children(M));
  }
  if (node.name == "polygon" || node.name == "square" || node.name == "circle") {
    throw CsgFailure(node, node.name + " is flat; put it into linear_extrude or rotate_extrude");
  }
  throw CsgFailure(node,
                   "'" + excerpt(node.name) + "' is not supported; rewrite the part with " + kSupported);
}

void set_facets(std::vector<CsgNode>& nodes, bool keep_facets) {
  for (CsgNode& node : nodes) {
    node.keep_facets = keep_facets;
    set_facets(node.children, keep_facets);
  }
}

}  // namespace

TopoDS_Shape build_csg(std::vector<CsgNode> nodes, bool keep_facets) {
  set_facets(nodes, keep_facets);
  std::vector<TopoDS_Shape> shapes;
  for (const CsgNode& node : nodes) shapes.push_back(build(node, {}));
  return nodes.empty() ? TopoDS_Shape() : unite(nodes[0], shapes);
}

}  // namespace tetragauge
