// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/turn_wires.hpp"

#include <BRepAdaptor_Surface.hxx>
#include <BRepTools_ReShape.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <cmath>
#include <vector>

namespace tetragauge {
namespace {

// Chords per edge: enough to tell the sense of a boundary, which is all that is asked.
constexpr int kChords = 64;

double signed_area(const TopoDS_Shape& wire, const TopoDS_Face& face) {
  double twice = 0;
  for (TopExp_Explorer explorer(wire, TopAbs_EDGE); explorer.More(); explorer.Next()) {
    const TopoDS_Edge edge = TopoDS::Edge(explorer.Current());
    double first = 0, last = 0;
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
    if (curve.IsNull()) continue;
    const double side = edge.Orientation() == TopAbs_REVERSED ? -1 : 1;
    gp_Pnt2d from = curve->Value(first);
    for (int i = 1; i <= kChords; ++i) {
      const gp_Pnt2d to = curve->Value(first + (last - first) * i / kChords);
      twice += side * (from.X() * to.Y() - to.X() * from.Y());
      from = to;
    }
  }
  return 0.5 * twice;
}

// The face with its wires turned; a null face if they are right.
TopoDS_Face turned(const TopoDS_Face& face) {
  std::vector<TopoDS_Shape> wires;
  std::vector<double> areas;
  size_t outer = 0;
  for (TopExp_Explorer wire(face, TopAbs_WIRE); wire.More(); wire.Next()) {
    wires.push_back(wire.Current());
    areas.push_back(signed_area(wire.Current(), face));
    if (std::abs(areas.back()) > std::abs(areas[outer])) outer = areas.size() - 1;
  }
  BRep_Builder builder;
  TopoDS_Face result = TopoDS::Face(face.EmptyCopied());
  bool is_changed = false;
  for (size_t i = 0; i < wires.size(); ++i) {
    const bool is_wrong = areas[i] != 0 && (areas[i] > 0) != (i == outer);
    is_changed |= is_wrong;
    builder.Add(result, is_wrong ? wires[i].Reversed() : wires[i]);
  }
  return is_changed ? result : TopoDS_Face();
}

}  // namespace

TopoDS_Shape turn_wires(const TopoDS_Shape& shape) {
  const Handle(BRepTools_ReShape) reshape = new BRepTools_ReShape;
  bool is_changed = false;
  for (TopExp_Explorer explorer(shape, TopAbs_FACE); explorer.More(); explorer.Next()) {
    const TopoDS_Face face = TopoDS::Face(explorer.Current().Oriented(TopAbs_FORWARD));
    if (BRepAdaptor_Surface(face, false).GetType() != GeomAbs_Plane) continue;
    const TopoDS_Face right = turned(face);
    if (right.IsNull()) continue;
    reshape->Replace(face, right);
    is_changed = true;
  }
  return is_changed ? reshape->Apply(shape) : shape;
}

}  // namespace tetragauge
