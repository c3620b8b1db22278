// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/solid_from_shape.hpp"

#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <ShapeUpgrade_ShapeDivideClosed.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Solid.hxx>
#include <cmath>

#include "host/solid/list_faces.hpp"
#include "host/solid/tessellate.hpp"
#include "host/solid/turn_wires.hpp"

namespace tetragauge {
namespace {

// Every solid at every place it stands, each place once.
std::vector<TopoDS_Solid> placed_solids(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape seen;
  std::vector<TopoDS_Solid> solids;
  for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next()) {
    const TopoDS_Shape placed = solid.Current().Oriented(TopAbs_FORWARD);
    if (seen.Contains(placed)) continue;
    seen.Add(placed);
    solids.push_back(TopoDS::Solid(solid.Current()));
  }
  return solids;
}

bool is_open(const TopoDS_Solid& solid) {
  TopTools_IndexedDataMapOfShapeListOfShape faces_of_edge;
  TopExp::MapShapesAndAncestors(solid, TopAbs_EDGE, TopAbs_FACE, faces_of_edge);
  for (int i = 1; i <= faces_of_edge.Extent(); ++i) {
    const TopoDS_Edge edge = TopoDS::Edge(faces_of_edge.FindKey(i));
    if (BRep_Tool::Degenerated(edge) || faces_of_edge(i).Extent() > 1) continue;
    if (!BRep_Tool::IsClosed(edge, TopoDS::Face(faces_of_edge(i).First()))) return true;  // not a seam
  }
  return faces_of_edge.IsEmpty();
}

double volume_mm3(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties);
  return properties.Mass();
}

void add_mass_properties(const std::vector<TopoDS_Solid>& shapes, Solid& solid) {
  Vec3 moment = Vec3::Zero();
  for (const TopoDS_Solid& shape : shapes) {
    GProp_GProps volume;
    BRepGProp::VolumeProperties(shape, volume);
    const gp_Pnt centre = volume.CentreOfMass();
    solid.volume_mm3 += volume.Mass();
    moment += volume.Mass() * Vec3(centre.X(), centre.Y(), centre.Z());
  }
  solid.centroid_mm = moment / solid.volume_mm3;
  for (const Face& face : solid.faces()) solid.area_mm2 += face.area_mm2;
}

// Of the true surfaces: the triangles of a ball miss its outermost points.
void add_box(const std::vector<TopoDS_Solid>& shapes, Solid& solid) {
  Bnd_Box box;
  for (const TopoDS_Solid& shape : shapes) BRepBndLib::AddOptimal(shape, box, false, false);
  const gp_Pnt low = box.CornerMin(), high = box.CornerMax();
  solid.box_min_mm = Vec3(low.X(), low.Y(), low.Z());
  solid.box_max_mm = Vec3(high.X(), high.Y(), high.Z());
}

// BRepMesh gives up on some full turns of a cone; halves of them it can do. The list of faces puts the halves
// together again.
std::vector<TopoDS_Solid> divide_full_turns(const std::vector<TopoDS_Solid>& solids) {
  std::vector<TopoDS_Solid> divided;
  for (const TopoDS_Solid& solid : solids) {
    ShapeUpgrade_ShapeDivideClosed divide(solid);
    divide.Perform();
    TopExp_Explorer found(divide.Result(), TopAbs_SOLID);
    divided.push_back(found.More() ? TopoDS::Solid(found.Current()) : solid);
  }
  return divided;
}

Error open_solid(const std::string& place) {
  return bad_input(place +
                   ": the body is open, faces are missing; repair it in the CAD system and export it again "
                   "as a solid");
}

}  // namespace

Result<Solid> solid_from_shape(const TopoDS_Shape& shape, const std::string& place,
                               const ReadSolidOptions& options) {
  if (shape.IsNull()) return bad_input(place + ": the model is empty; it must hold at least one solid body");
  std::vector<TopoDS_Solid> shapes = placed_solids(turn_wires(shape));
  if (shapes.empty() && TopExp_Explorer(shape, TopAbs_SHELL).More()) return open_solid(place);
  if (shapes.empty()) {
    return bad_input(place + ": no solid body in it, only surfaces or curves; export the part as a solid");
  }
  const bool has_loose_surfaces = TopExp_Explorer(shape, TopAbs_FACE, TopAbs_SOLID).More();
  for (TopoDS_Solid& solid : shapes) {
    if (is_open(solid)) return open_solid(place);
    BRepLib::OrientClosedSolid(solid);
    if (!(volume_mm3(solid) > 0)) {
      return bad_input(place + ": a solid has no volume; repair it in the CAD system and export again");
    }
  }

  Solid solid;
  solid.solids = static_cast<int>(shapes.size());
  ListedFaces faces = list_faces(shapes);
  solid.list = faces.list;
  add_mass_properties(shapes, solid);
  if (has_loose_surfaces) {
    solid.warnings.push_back(place + ": surfaces beside the solid body are left out");
  }
  Tessellation tessellation = tessellate(faces, options.tessellation_mm);
  if (!tessellation.is_complete) {
    faces = list_faces(divide_full_turns(shapes));
    solid.list = faces.list;
    tessellation = tessellate(faces, options.tessellation_mm);
  }
  if (tessellation.triangles.empty()) {
    return bad_input(place + ": the model could not be meshed; check its faces in the CAD system");
  }
  if (!tessellation.is_closed || !tessellation.is_complete) {
    solid.warnings.push_back(place +
                             ": the triangles of the model do not close; rays may leak through its edges");
  }
  solid.vertices = std::move(tessellation.vertices);
  solid.triangles = std::move(tessellation.triangles);
  solid.triangle_face = std::move(tessellation.triangle_face);
  solid.surfaces = std::move(tessellation.surfaces);
  solid.on_surface = std::move(tessellation.on_surface);
  add_box(shapes, solid);
  return solid;
}

}  // namespace tetragauge
