// SPDX-License-Identifier: GPL-3.0-or-later
// A solid with two free-form sides for tests, through a STEP file as a user would give it. Its sides are
// Bezier surfaces that the tests evaluate themselves.
#pragma once

#include <gtest/gtest.h>

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Curve.hxx>
#include <STEPControl_Writer.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Wire.hxx>
#include <array>
#include <filesystem>
#include <gp_Pln.hxx>
#include <string>

#include "host/solid/solid.hpp"

namespace tetragauge::test {

// Control points of degree 4 in u (along the chord) and 3 in v (along the span).
using BladeSide = std::array<std::array<Vec3, 4>, 5>;

// The solid between two sides that share their edges u = 0 and u = 1, from the plane z = 0 (v = 0) to the
// plane z = `height_mm` (v = 1).
inline Solid blade(const BladeSide& one, const BladeSide& other, double height_mm) {
  BRepBuilderAPI_Sewing sewing(1e-5);
  std::array<Handle(Geom_BezierSurface), 2> surfaces;
  for (size_t s = 0; s < 2; ++s) {
    TColgp_Array2OfPnt poles(1, 5, 1, 4);
    for (size_t i = 0; i < 5; ++i) {
      for (size_t k = 0; k < 4; ++k) {
        const Vec3& p = (s == 0 ? one : other)[i][k];
        poles.SetValue(static_cast<int>(i) + 1, static_cast<int>(k) + 1, gp_Pnt(p.x(), p.y(), p.z()));
      }
    }
    surfaces[s] = new Geom_BezierSurface(poles);
    sewing.Add(BRepBuilderAPI_MakeFace(surfaces[s], 1e-7).Face());
  }
  for (const double v : {0.0, 1.0}) {
    BRepBuilderAPI_MakeWire wire;
    for (const auto& surface : surfaces) wire.Add(BRepBuilderAPI_MakeEdge(surface->VIso(v)).Edge());
    const gp_Pln plane(gp_Pnt(0, 0, height_mm * v), gp_Dir(0, 0, 1));
    sewing.Add(BRepBuilderAPI_MakeFace(plane, wire.Wire()).Face());
  }
  sewing.Perform();
  TopoDS_Solid whole = BRepBuilderAPI_MakeSolid(TopoDS::Shell(sewing.SewedShape())).Solid();
  BRepLib::OrientClosedSolid(whole);
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / (std::string("tetragauge_blade_") + info->name() + ".step");
  STEPControl_Writer writer;
  writer.Transfer(whole, STEPControl_AsIs);
  writer.Write(path.c_str());
  Result<Solid> read = read_solid(path);
  std::filesystem::remove(path);
  if (!read) {
    ADD_FAILURE() << read.error().message;
    return {};
  }
  return std::move(read).value();
}

}  // namespace tetragauge::test
