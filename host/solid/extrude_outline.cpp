// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/extrude_outline.hpp"

#include <BRepAdaptor_Curve.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <cmath>
#include <gp_Ax1.hxx>
#include <numbers>
#include <optional>

#include "host/solid/build_outline.hpp"
#include "host/solid/polyhedral_solid.hpp"

namespace tetragauge {
namespace {

using Loop3 = std::vector<Vec3>;
using Loops = std::vector<Loop3>;  // outer first, holes the other way round

// Corners of each face of an outline, in z = 0, counter-clockwise; nullopt if an edge is not straight.
std::optional<std::vector<Loops>> straight_loops(const TopoDS_Shape& outline) {
  std::vector<Loops> faces;
  for (TopExp_Explorer face(outline, TopAbs_FACE); face.More(); face.Next()) {
    const TopoDS_Face upward = TopoDS::Face(face.Current().Oriented(TopAbs_FORWARD));
    const TopoDS_Wire outer = BRepTools::OuterWire(upward);
    Loops loops(1);
    for (TopExp_Explorer wire(upward, TopAbs_WIRE); wire.More(); wire.Next()) {
      Loop3 loop;
      for (BRepTools_WireExplorer edge(TopoDS::Wire(wire.Current()), upward); edge.More(); edge.Next()) {
        if (BRepAdaptor_Curve(edge.Current()).GetType() != GeomAbs_Line) return std::nullopt;
        const gp_Pnt p = BRep_Tool::Pnt(edge.CurrentVertex());
        loop.emplace_back(p.X(), p.Y(), p.Z());
      }
      if (wire.Current().IsSame(outer)) {
        loops[0] = std::move(loop);
      } else {
        loops.push_back(std::move(loop));
      }
    }
    faces.push_back(std::move(loops));
  }
  return faces;
}

class MeshWriter {
 public:
  size_t add(const Vec3& p) {
    mesh_.corners.push_back(p);
    return mesh_.corners.size() - 1;
  }
  void add_face(const Loops& loops, bool is_reversed) {
    PolyhedralFace face;
    for (size_t i = 0; i < loops.size(); ++i) {
      CornerLoop corners;
      for (const Vec3& p : loops[i]) corners.push_back(add(p));
      if (is_reversed) std::reverse(corners.begin(), corners.end());
      (i == 0 ? face.outer : face.holes.emplace_back()) = std::move(corners);
    }
    mesh_.faces.push_back(std::move(face));
  }
  // Joins a loop to its copy one step further, by a four-sided face per edge.
  void add_band(const Loop3& from, const Loop3& to) {
    for (size_t i = 0; i < from.size(); ++i) {
      const size_t j = (i + 1) % from.size();
      add_face({{from[i], from[j], to[j], to[i]}}, false);
    }
  }
  PolyhedralMesh take() { return std::move(mesh_); }

 private:
  PolyhedralMesh mesh_;
};

TopoDS_Shape solid_of(const CsgNode& node, PolyhedralMesh mesh) {
  try {
    return polyhedral_solid(std::move(mesh));
  } catch (const PolyhedronFailure& failure) {
    throw CsgFailure(node, node.name + ": " + failure.what());
  }
}

TopoDS_Compound compound_of(const std::vector<TopoDS_Shape>& shapes) {
  BRep_Builder builder;
  TopoDS_Compound compound;
  builder.MakeCompound(compound);
  for (const TopoDS_Shape& shape : shapes) builder.Add(compound, shape);
  return compound;
}

Loops map(const Loops& loops, const auto& move) {
  Loops result = loops;
  for (Loop3& loop : result) {
    for (Vec3& p : loop) p = move(p);
  }
  return result;
}

// A stack of copies of the outline joined by bands, each corner moved by M last: exact under any affine map.
// With `is_ring` the last copy is the first, and there are no ends.
TopoDS_Shape faceted_sweep(const CsgNode& node, const std::vector<Loops>& faces, size_t copies, bool is_ring,
                           const auto& place) {
  std::vector<TopoDS_Shape> solids;
  for (const Loops& loops : faces) {
    MeshWriter mesh;
    const auto copy = [&](size_t k) { return map(loops, [&](const Vec3& p) { return place(p, k); }); };
    for (size_t k = 0; k + 1 < copies; ++k) {
      const Loops from = copy(k), to = is_ring && k + 2 == copies ? copy(0) : copy(k + 1);
      for (size_t i = 0; i < loops.size(); ++i) mesh.add_band(from[i], to[i]);
    }
    if (!is_ring) {
      mesh.add_face(copy(0), true);
      mesh.add_face(copy(copies - 1), false);
    }
    solids.push_back(solid_of(node, mesh.take()));
  }
  return compound_of(solids);
}

std::string not_exact(const CsgNode& node, const std::string& why) {
  return node.name + ": " + why + " has no exact surface here; give the round parts $fn of 3 to 36";
}

}  // namespace

TopoDS_Shape moved(const TopoDS_Shape& shape, const gp_Trsf& T) {
  return BRepBuilderAPI_Transform(shape, T, true).Shape();
}

TopoDS_Shape linear_extrude(const CsgNode& node, const Affine& M) {
  const double height = positive_argument(node, "height");
  if (number_argument(node, "twist", 0) != 0) {
    throw CsgFailure(node,
                     "linear_extrude: 'twist' is not supported; a twisted surface is no plane or cylinder");
  }
  if (find_argument(node, "scale") && vector_argument(node, "scale", 2) != std::vector<double>{1, 1}) {
    throw CsgFailure(node, "linear_extrude: 'scale' is not supported; use a polyhedron or a cone");
  }
  const TopoDS_Shape outline = build_outline(node.children);
  if (outline.IsNull()) return {};
  const double bottom = bool_argument(node, "center", false) ? -height / 2 : 0;

  if (const auto faces = straight_loops(outline)) {
    return faceted_sweep(node, *faces, 2, false, [&](const Vec3& p, size_t k) {
      return M * Vec3(p.x(), p.y(), bottom + (k == 0 ? 0 : height));
    });
  }
  const std::optional<AxialScale> scale = axial_scale(M);
  if (!scale) throw CsgFailure(node, not_exact(node, "a round outline under a skew or uneven scale"));
  gp_Trsf lift;
  lift.SetTranslation(gp_Vec(0, 0, bottom * scale->along_z));
  const gp_Vec sweep(0, 0, height * scale->along_z);
  return moved(BRepPrimAPI_MakePrism(moved(outline, lift), sweep).Shape(), scale->S);
}

TopoDS_Shape rotate_extrude(const CsgNode& node, const Affine& M) {
  const double angle_deg = number_argument(node, "angle", 360);
  const double clamped_deg = std::abs(angle_deg) > 360 ? 360 : angle_deg;
  if (clamped_deg == 0) throw CsgFailure(node, "rotate_extrude: 'angle' must not be 0");
  const bool is_ring = std::abs(clamped_deg) == 360;
  const std::optional<AxialScale> scale = axial_scale(M);
  const bool is_faceted = facets(node, 1) > 0;

  Affine stretch;  // the outline's y becomes z
  if (!is_faceted && scale) stretch.A(1, 1) = scale->along_z;
  const TopoDS_Shape outline = build_outline(node.children, stretch);
  if (outline.IsNull()) return {};
  double reach = 0;
  for (TopExp_Explorer vertex(outline, TopAbs_VERTEX); vertex.More(); vertex.Next()) {
    const double x = BRep_Tool::Pnt(TopoDS::Vertex(vertex.Current())).X();
    reach = std::max(reach, x);
    if (x >= -1e-9) continue;
    throw CsgFailure(node,
                     "rotate_extrude: the outline must lie at x >= 0; move it to the right of the axis");
  }

  if (is_faceted) {
    const size_t sides = facets(node, reach);
    const auto faces = straight_loops(outline);
    if (!faces) throw CsgFailure(node, not_exact(node, "a round outline turned in facets"));
    // OpenSCAD starts a full turn at -x, a part of one at +x, and takes its share of $fn for a part, at
    // least 1.
    const double turn = clamped_deg / 360;
    const double steps = is_ring ? static_cast<double>(sides)
                                 : std::max(std::floor(static_cast<double>(sides) * std::abs(turn)), 1.0);
    const double start = is_ring ? std::numbers::pi : 0;
    return faceted_sweep(node, *faces, static_cast<size_t>(steps) + 1, is_ring, [&](const Vec3& p, size_t k) {
      const double phi = start + 2 * std::numbers::pi * turn * static_cast<double>(k) / steps;
      const double x = std::max(p.x(), 0.0);
      return M * Vec3(x * std::cos(phi), x * std::sin(phi), p.y());
    });
  }
  if (!scale) throw CsgFailure(node, not_exact(node, "a turned outline under a skew or uneven scale"));
  gp_Trsf upright;  // x stays, y becomes z
  upright.SetValues(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0);
  const TopoDS_Shape standing = moved(outline, upright);
  const gp_Ax1 axis(gp::Origin(), gp::DZ());
  const TopoDS_Shape turned =
      is_ring ? BRepPrimAPI_MakeRevol(standing, axis).Shape()
              : BRepPrimAPI_MakeRevol(standing, axis, clamped_deg * std::numbers::pi / 180).Shape();
  return moved(turned, scale->S);
}

}  // namespace tetragauge
