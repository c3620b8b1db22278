// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/build_outline.hpp"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRep_Builder.hxx>
#include <ShapeUpgrade_UnifySameDomain.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Circ.hxx>
#include <gp_Pln.hxx>
#include <numbers>

#include "host/solid/combine_shapes.hpp"

namespace tetragauge {
namespace {

using Vec2 = Eigen::Vector2d;
using Loop = std::vector<Vec2>;

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double signed_area(const Loop& loop) {
  double twice = 0;
  for (size_t i = 0; i < loop.size(); ++i) {
    twice += cross(loop[i] - loop[0], loop[(i + 1) % loop.size()] - loop[0]);
  }
  return 0.5 * twice;
}

bool contains(const Loop& loop, const Vec2& p) {
  bool is_inside = false;
  for (size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) is_inside = !is_inside;
  }
  return is_inside;
}

bool cross_properly(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const double c_side = cross(b - a, c - a), d_side = cross(b - a, d - a);
  const double a_side = cross(d - c, a - c), b_side = cross(d - c, b - c);
  return ((c_side > 0) != (d_side > 0)) && ((a_side > 0) != (b_side > 0)) && c_side != 0 && d_side != 0 &&
         a_side != 0 && b_side != 0;
}

void check_simple(const CsgNode& node, const std::vector<Loop>& loops) {
  std::vector<std::pair<Vec2, Vec2>> edges;
  for (const Loop& loop : loops) {
    for (size_t i = 0; i < loop.size(); ++i) edges.emplace_back(loop[i], loop[(i + 1) % loop.size()]);
  }
  for (size_t i = 0; i < edges.size(); ++i) {
    for (size_t j = i + 1; j < edges.size(); ++j) {
      if (!cross_properly(edges[i].first, edges[i].second, edges[j].first, edges[j].second)) continue;
      throw CsgFailure(node, node.name + ": its outline crosses itself near (" +
                                 std::to_string(edges[j].first.x()) + ", " +
                                 std::to_string(edges[j].first.y()) + "); make the outline simple");
    }
  }
}

TopoDS_Wire wire_of(const CsgNode& node, Loop loop, bool is_hole) {
  if ((signed_area(loop) < 0) != is_hole) std::reverse(loop.begin(), loop.end());
  BRepBuilderAPI_MakePolygon polygon;
  for (const Vec2& p : loop) polygon.Add(gp_Pnt(p.x(), p.y(), 0));
  polygon.Close();
  if (!polygon.IsDone()) throw CsgFailure(node, node.name + ": its points do not make an outline");
  return polygon.Wire();
}

// Loops are filled by the even-odd rule, as OpenSCAD fills `paths`: a loop inside an odd number of others is
// a hole of the innermost of them.
TopoDS_Shape face_of_loops(const CsgNode& node, const std::vector<Loop>& loops) {
  check_simple(node, loops);
  for (const Loop& loop : loops) {
    if (signed_area(loop) == 0) throw CsgFailure(node, node.name + ": an outline has no area; leave it out");
  }
  std::vector<std::vector<size_t>> around(loops.size());
  for (size_t i = 0; i < loops.size(); ++i) {
    for (size_t j = 0; j < loops.size(); ++j) {
      if (i != j && contains(loops[j], loops[i][0])) around[i].push_back(j);
    }
  }
  BRep_Builder builder;
  TopoDS_Compound faces;
  builder.MakeCompound(faces);
  for (size_t outer = 0; outer < loops.size(); ++outer) {
    if (around[outer].size() % 2 == 1) continue;
    BRepBuilderAPI_MakeFace face(gp_Pln(gp::XOY()), wire_of(node, loops[outer], false));
    for (size_t hole = 0; hole < loops.size(); ++hole) {
      const bool is_own = around[hole].size() == around[outer].size() + 1 &&
                          std::find(around[hole].begin(), around[hole].end(), outer) != around[hole].end();
      if (is_own) face.Add(wire_of(node, loops[hole], true));
    }
    builder.Add(faces, face.Face());
  }
  return faces;
}

Vec2 moved(const Affine& M, const Vec2& p) {
  return M.A.topLeftCorner<2, 2>() * p + M.t.head<2>();
}

TopoDS_Shape polygon(const CsgNode& node, const Affine& M) {
  Loop points;
  for (const std::vector<double>& row : rows_argument(node, "points", 2)) {
    points.push_back(moved(M, {row[0], row[1]}));
  }
  std::vector<Loop> loops;
  for (const std::vector<size_t>& path : index_lists_argument(node, "paths", points.size())) {
    Loop& loop = loops.emplace_back();
    for (size_t index : path) loop.push_back(points[index]);
  }
  if (loops.empty()) loops.push_back(points);
  for (Loop& loop : loops) {
    loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    if (loop.size() < 3) {
      throw CsgFailure(node, "polygon: an outline needs three points");
    }
  }
  return face_of_loops(node, loops);
}

TopoDS_Shape square(const CsgNode& node, const Affine& M) {
  const std::vector<double> size = vector_argument(node, "size", 2);
  if (!(size[0] > 0) || !(size[1] > 0)) throw CsgFailure(node, "square: 'size' must be above 0");
  const Vec2 low = bool_argument(node, "center", false) ? Vec2(-size[0] / 2, -size[1] / 2) : Vec2(0, 0);
  return face_of_loops(node, {{moved(M, low), moved(M, low + Vec2(size[0], 0)),
                               moved(M, low + Vec2(size[0], size[1])), moved(M, low + Vec2(0, size[1]))}});
}

TopoDS_Shape circle(const CsgNode& node, const Affine& M) {
  const double radius = positive_argument(node, "r");
  if (const size_t sides = facets(node, radius)) {
    Loop loop;
    for (size_t i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(sides);
      loop.push_back(moved(M, radius * Vec2(std::cos(angle), std::sin(angle))));
    }
    return face_of_loops(node, {loop});
  }
  const Vec2 a = M.A.topLeftCorner<2, 1>(), b = M.A.block<2, 1>(0, 1);
  const double scale = 0.5 * (a.norm() + b.norm());
  if (!(scale > 0) || std::abs(a.norm() - b.norm()) > 1e-9 * scale ||
      std::abs(a.dot(b)) > 1e-9 * scale * scale) {
    throw CsgFailure(node,
                     "circle: scaled to an ellipse, which has no exact surface here; give it $fn of 3 to 36");
  }
  const gp_Circ round(gp_Ax2(gp_Pnt(M.t.x(), M.t.y(), 0), gp::DZ(), gp_Dir(a.x(), a.y(), 0)), scale * radius);
  const TopoDS_Wire wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(round).Edge()).Wire();
  return BRepBuilderAPI_MakeFace(gp_Pln(gp::XOY()), wire).Face();
}

TopoDS_Shape outline(const CsgNode& node, const Affine& M) {
  const auto children = [&] {
    std::vector<TopoDS_Shape> shapes;
    for (const CsgNode& child : node.children) shapes.push_back(outline(child, M));
    return shapes;
  };
  if (node.name == "polygon") return polygon(node, M);
  if (node.name == "square") return square(node, M);
  if (node.name == "circle") return circle(node, M);
  if (node.name == "multmatrix") return build_outline(node.children, M * matrix_argument(node));
  if (node.name == "difference") return subtract(node, children());
  if (node.name == "intersection") return intersect(node, children());
  if (node.name == "group" || node.name == "union" || node.name == "color" || node.name == "render") {
    return unite(node, children());
  }
  throw CsgFailure(node, "'" + node.name +
                             "' is not supported inside an extrusion; use polygon, square, circle, "
                             "multmatrix, union, difference or intersection");
}

}  // namespace

TopoDS_Shape build_outline(const std::vector<CsgNode>& nodes, const Affine& M) {
  std::vector<TopoDS_Shape> shapes;
  for (const CsgNode& node : nodes) shapes.push_back(outline(node, M));
  const TopoDS_Shape whole = nodes.empty() ? TopoDS_Shape() : unite(nodes[0], shapes);
  if (whole.IsNull()) return whole;
  // A Boolean leaves the seams of its parts in the plane; swept, each part would become a body of its own.
  ShapeUpgrade_UnifySameDomain seams(whole, true, true, false);
  seams.Build();
  return seams.Shape();
}

}  // namespace tetragauge
