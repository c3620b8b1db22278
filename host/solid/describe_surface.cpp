// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/describe_surface.hpp"

#include <BRepAdaptor_Surface.hxx>
#include <BRepGProp.hxx>
#include <BRepTools.hxx>
#include <GProp_GProps.hxx>
#include <cmath>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Pln.hxx>
#include <gp_Sphere.hxx>
#include <gp_Torus.hxx>

namespace tetragauge {
namespace {

Vec3 vec(const gp_XYZ& v) {
  return {v.X(), v.Y(), v.Z()};
}

// An axis has no sense of its own: the first component that is not nil is made positive.
Vec3 canonical_axis(const Vec3& axis) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(axis[i]) > 1e-9) return axis[i] > 0 ? axis : Vec3(-axis);
  }
  return axis;
}

struct Sample {
  Vec3 point, normal;  // normal points out of the material
};

// A regular point of the surface, away from poles and apex.
Sample sample_surface(const TopoDS_Face& face, const BRepAdaptor_Surface& surface) {
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  gp_Pnt p;
  gp_Vec du, dv;
  Vec3 normal = Vec3::Zero();
  for (const double share : {0.5, 0.37, 0.71, 0.13}) {
    surface.D1(u0 + share * (u1 - u0), v0 + share * (v1 - v0), p, du, dv);
    normal = vec(du.XYZ()).cross(vec(dv.XYZ()));
    if (normal.norm() > 1e-12) break;
  }
  if (face.Orientation() == TopAbs_REVERSED) normal = -normal;
  return {vec(p.XYZ()), normal.normalized()};
}

void describe_plane(const gp_Pln& plane, const Sample& sample, Face& face) {
  face.type = SurfaceType::plane;
  const Vec3 normal = vec(plane.Axis().Direction().XYZ());
  face.normal = normal.dot(sample.normal) >= 0 ? normal : Vec3(-normal);
  face.d_mm = face.normal.dot(vec(plane.Location().XYZ()));
}

void describe_cylinder(const gp_Cylinder& cylinder, const Sample& sample, Face& face) {
  face.type = SurfaceType::cylinder;
  face.axis = canonical_axis(vec(cylinder.Axis().Direction().XYZ()));
  face.radius_mm = cylinder.Radius();
  const Vec3 origin = vec(cylinder.Location().XYZ());
  face.point_on_axis_mm = origin + face.axis * face.axis.dot(face.point_mm - origin);
  const Vec3 radial = sample.point - origin;
  face.concave = (radial - face.axis * face.axis.dot(radial)).dot(sample.normal) < 0;
}

void describe_cone(const gp_Cone& cone, const Sample& sample, Face& face) {
  face.type = SurfaceType::cone;
  const double angle = cone.SemiAngle();
  const Vec3 direction = vec(cone.Axis().Direction().XYZ());
  const Vec3 apex = vec(cone.Apex().XYZ());
  face.half_angle_rad = std::abs(angle);
  // The nappe that holds the face decides which way the radius grows.
  face.axis = direction.dot(sample.point - apex) >= 0 ? direction : Vec3(-direction);
  const double height = face.axis.dot(face.point_mm - apex);
  face.point_on_axis_mm = apex + face.axis * height;
  face.radius_mm = height * std::tan(face.half_angle_rad);
  const Vec3 from_apex = sample.point - apex;
  face.concave = (from_apex - face.axis * face.axis.dot(from_apex)).dot(sample.normal) < 0;
}

void describe_sphere(const gp_Sphere& sphere, const Sample& sample, Face& face) {
  face.type = SurfaceType::sphere;
  face.radius_mm = sphere.Radius();
  face.point_on_axis_mm = vec(sphere.Location().XYZ());
  face.concave = (sample.point - face.point_on_axis_mm).dot(sample.normal) < 0;
}

void describe_torus(const gp_Torus& torus, const Sample& sample, Face& face) {
  face.type = SurfaceType::torus;
  face.axis = canonical_axis(vec(torus.Axis().Direction().XYZ()));
  face.radius_mm = torus.MajorRadius();
  face.minor_radius_mm = torus.MinorRadius();
  face.point_on_axis_mm = vec(torus.Location().XYZ());
  const Vec3 r = sample.point - face.point_on_axis_mm;
  const Vec3 radial = (r - face.axis * face.axis.dot(r)).normalized();
  face.concave = (r - radial * torus.MajorRadius()).dot(sample.normal) < 0;
}

}  // namespace

Face describe_surface(const TopoDS_Face& shape) {
  Face face;
  GProp_GProps properties;
  BRepGProp::SurfaceProperties(shape, properties);
  face.area_mm2 = std::abs(properties.Mass());
  face.point_mm = vec(properties.CentreOfMass().XYZ());

  const BRepAdaptor_Surface surface(shape, false);
  const Sample sample = sample_surface(shape, surface);
  switch (surface.GetType()) {
    case GeomAbs_Plane:
      describe_plane(surface.Plane(), sample, face);
      break;
    case GeomAbs_Cylinder:
      describe_cylinder(surface.Cylinder(), sample, face);
      break;
    case GeomAbs_Cone:
      describe_cone(surface.Cone(), sample, face);
      break;
    case GeomAbs_Sphere:
      describe_sphere(surface.Sphere(), sample, face);
      break;
    case GeomAbs_Torus:
      describe_torus(surface.Torus(), sample, face);
      break;
    default:
      face.type = SurfaceType::other;
      break;
  }
  return face;
}

}  // namespace tetragauge
