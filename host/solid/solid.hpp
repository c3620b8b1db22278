// SPDX-License-Identifier: GPL-3.0-or-later
// The solid model of a part, whatever file it came from: analytic faces, a tessellation that knows its faces,
// mass properties. Model frame, mm.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/result.hpp"
#include "host/geometry/face.hpp"
#include "host/geometry/rigid_transform.hpp"
#include "host/solid/parametric_surface.hpp"

namespace tetragauge {

struct ReadSolidOptions {
  std::optional<double> unit_scale_mm;  // for files that state no unit (all but STEP); mm unless given
  // .csg: $fn as written, whatever it is; meshes: every plane facet is a face, none is taken for part of a
  // curve.
  bool keep_facets = false;
  double tessellation_mm = 0.02;  // chordal deviation of the triangles from the true face
};

struct Solid {
  FaceList list;  // canonical order: type, normal or axis, offset, centroid; not the order of the file

  // Tessellation: outward counter-clockwise triangles.
  std::vector<Vec3> vertices;  // mm
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> triangle_face;  // index into list.faces

  // Of STEP's free-form faces the true surfaces, and which piece of one lies under each of their triangles
  // (ascending).
  std::vector<std::shared_ptr<const ParametricSurface>> surfaces;
  std::vector<TriangleOnSurface> on_surface;

  double volume_mm3 = 0, area_mm2 = 0;
  Vec3 centroid_mm = Vec3::Zero();
  Vec3 box_min_mm = Vec3::Zero(), box_max_mm = Vec3::Zero();
  std::string declared_unit;          // "mm", "inch", ... as the file says; "" if it says nothing
  std::vector<std::string> warnings;  // e.g. a suspicious unit
  int solids = 1;                     // bodies, an assembly's parts once at each of their places

  const std::vector<Face>& faces() const { return list.faces; }
};

// .step .stp (declared unit to mm), .csg (as OpenSCAD exports it), meshes: .stl .obj .ply .off. Unreadable or
// open solids are errors.
Result<Solid> read_solid(const std::filesystem::path& path, const ReadSolidOptions& options = {});

// The same solid turned and shifted: p' = T * p. Ids stay those of the input.
Solid transformed(const Solid& solid, const RigidTransform& T);

// Signed distance of p to the face's analytic surface, positive outside the material. Precondition: the type
// is not `other`.
double distance_to_surface(const Face& face, const Vec3& p);

}  // namespace tetragauge
