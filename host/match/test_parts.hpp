// SPDX-License-Identifier: GPL-3.0-or-later
// Parts for the tests of match, inspect and report: their planes written down by hand, not by any code under
// test.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "host/geometry/face.hpp"
#include "host/geometry/rigid_transform.hpp"

namespace tetragauge::test {

// A flat face as a convex polygon, counter-clockwise seen from outside.
struct Polygon {
  std::vector<Vec3> corners;
};

inline Face face_of(const Polygon& polygon, int id) {
  Vec3 area = Vec3::Zero(), centroid = Vec3::Zero();
  const Vec3 first = polygon.corners[0];
  double total = 0;
  for (size_t k = 1; k + 1 < polygon.corners.size(); ++k)
    area += 0.5 * (polygon.corners[k] - first).cross(polygon.corners[k + 1] - first);
  const Vec3 normal = area.normalized();
  for (size_t k = 1; k + 1 < polygon.corners.size(); ++k) {
    const double part = 0.5 * (polygon.corners[k] - first).cross(polygon.corners[k + 1] - first).dot(normal);
    centroid += part * (first + polygon.corners[k] + polygon.corners[k + 1]) / 3;
    total += part;
  }
  Face face;
  face.id = face.surface = id;
  face.normal = normal;
  face.point_mm = centroid / total;
  face.d_mm = normal.dot(face.point_mm);
  face.area_mm2 = total;
  return face;
}

// A polygon in (x, z), counter-clockwise seen against y (x right, z up), swept over y = 0..depth. Its two
// ends are faces too (the shoelace formula, so that the outline need not be convex).
inline FaceList prism(const std::vector<std::array<double, 2>>& xz, double depth) {
  FaceList list;
  const auto at = [&](size_t k, double y) { return Vec3(xz[k % xz.size()][0], y, xz[k % xz.size()][1]); };
  for (size_t k = 0; k < xz.size(); ++k)
    list.faces.push_back(
        face_of({{at(k, 0), at(k, depth), at(k + 1, depth), at(k + 1, 0)}}, static_cast<int>(k) + 1));
  double area = 0;
  Vec3 centroid = Vec3::Zero();
  for (size_t k = 0; k < xz.size(); ++k) {
    const Vec3 a = at(k, 0), b = at(k + 1, 0);
    const double cross = 0.5 * (a.x() * b.z() - b.x() * a.z());
    area += cross;
    centroid += cross * (a + b) / 3;
  }
  centroid /= area;
  for (const double y : {0.0, depth}) {
    Face end;
    end.id = end.surface = static_cast<int>(list.faces.size()) + 1;
    end.normal = Vec3(0, y > 0 ? 1 : -1, 0);
    end.point_mm = centroid + Vec3(0, y, 0);
    end.d_mm = end.normal.dot(end.point_mm);
    end.area_mm2 = area;
    list.faces.push_back(end);
  }
  return list;
}

// The thesis's staircase in mm: ids 1..13 follow the outline, 14 and 15 are the ends y = 0 and y = 60.
inline FaceList staircase() {
  FaceList list = prism({{0, 0},
                         {80, 0},
                         {80, 20},
                         {60, 20},
                         {60, 40},
                         {40, 40},
                         {40, 50},
                         {20, 50},
                         {20, 60},
                         {0, 60},
                         {0, 40},
                         {30, 10},
                         {0, 10}},
                        60);
  list.faces[12].surface = list.faces[9].surface;  // both on x = 0
  return list;
}

inline FaceList box(double x, double y, double z) {
  return prism({{0, 0}, {x, 0}, {x, z}, {0, z}}, y);
}

// The thesis's channel: 100 x 60 x 40 mm less the slot y 20..40, z 20..40 along all of x. The sweep runs
// along y here, so its length of 100 mm is along y and the section lies in x, z.
inline FaceList channel() {
  return prism({{0, 0}, {60, 0}, {60, 40}, {40, 40}, {40, 20}, {20, 20}, {20, 40}, {0, 40}}, 100);
}

inline FaceList polygon_prism(int sides, double radius, double depth) {
  std::vector<std::array<double, 2>> xz;
  for (int k = 0; k < sides; ++k) {
    const double turn = 2 * std::numbers::pi * k / sides;
    xz.push_back({radius * std::cos(turn), radius * std::sin(turn)});
  }
  return prism(xz, depth);
}

// Uniform in rotations; `reach_mm` bounds each coordinate of the shift.
inline RigidTransform random_pose(std::mt19937_64& random, double reach_mm = 100) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-reach_mm, reach_mm);
  Eigen::Quaterniond q;
  q.w() = normal(random);
  q.x() = normal(random);
  q.y() = normal(random);
  q.z() = normal(random);
  q.normalize();
  RigidTransform T;
  T.R = q.toRotationMatrix();
  for (int k = 0; k < 3; ++k) T.t[k] = uniform(random);
  return T;
}

inline Face moved(Face face, const RigidTransform& T) {
  face.normal = T.R * face.normal;
  face.point_mm = T * face.point_mm;
  face.d_mm = face.normal.dot(face.point_mm);
  return face;
}

inline FaceList moved(FaceList list, const RigidTransform& T) {
  for (Face& face : list.faces) face = moved(face, T);
  return list;
}

// Turns the normal by about `angle_rad` each way and shifts the plane by about `offset_mm`, both normally
// distributed.
inline void disturb(Face& face, double angle_rad, double offset_mm, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto [u, v] = tangent_frame(face.normal);
  const double turn_u = angle_rad * normal(random), turn_v = angle_rad * normal(random);
  face.point_mm += offset_mm * normal(random) * face.normal;
  face.normal = (face.normal + turn_u * u + turn_v * v).normalized();
  face.d_mm = face.normal.dot(face.point_mm);
}

inline void number_from_one(FaceList& list) {
  for (size_t k = 0; k < list.faces.size(); ++k) list.faces[k].id = static_cast<int>(k) + 1;
}

}  // namespace tetragauge::test
