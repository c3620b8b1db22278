// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/relate_faces.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "host/inspect/applies_to.hpp"
#include "host/inspect/plane_deviation.hpp"

namespace tetragauge {
namespace {

void relate_angle(const Face& a, const Face& b, const PlaneAsMeasured& seen_a, const PlaneAsMeasured& seen_b,
                  FaceRelation& out) {
  out.nominal_angle_rad = std::atan2(a.normal.cross(b.normal).norm(), a.normal.dot(b.normal));
  const Vec3 turn = tilt_of(seen_b, b.normal) - tilt_of(seen_a, a.normal);
  const Mat3 covariance = tilt_covariance(seen_a) + tilt_covariance(seen_b);
  if (out.are_parallel) {  // any way off is off: the angle between them has no sign
    out.angle_deviation_rad = turn.norm();
    const double largest = Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvalues()[2];
    out.U_angle_rad = 2 * std::sqrt(std::max(0.0, largest));
    return;
  }
  const Vec3 hinge = a.normal.cross(b.normal).normalized();
  out.angle_deviation_rad = hinge.dot(turn);
  out.U_angle_rad = 2 * std::sqrt(std::max(0.0, hinge.dot(covariance * hinge)));
}

// Amid the two centroids: there a turn of the part moves both alike.
void relate_distance(const Face& a, const Face& b, const PlaneAsMeasured& seen_a,
                     const PlaneAsMeasured& seen_b, FaceRelation& out) {
  const double side = a.normal.dot(b.normal) > 0 ? 1 : -1;
  const double along = a.normal.dot(b.point_mm) - a.d_mm;  // + : b lies before a
  out.nominal_distance_mm = std::abs(along);
  const Vec3 middle = 0.5 * (a.point_mm + b.point_mm);
  const Vec3 on_a = middle - a.normal * (a.normal.dot(middle) - a.d_mm);
  const Vec3 on_b = middle - b.normal * (b.normal.dot(middle) - b.d_mm);
  const double moved = side * height(seen_b, b.normal, on_b) - height(seen_a, a.normal, on_a);
  out.distance_deviation_mm = along < 0 ? -moved : moved;
  out.U_distance_mm = 2 * std::sqrt(own_height_variance(seen_a, on_a) + own_height_variance(seen_b, on_b));
}

}  // namespace

std::vector<FaceRelation> relate_faces(const Solid& model, const std::vector<FaceInspection>& faces) {
  std::vector<FaceRelation> relations;
  for (size_t a = 0; a < faces.size(); ++a) {
    for (size_t b = a + 1; b < faces.size(); ++b) {
      const Face &first = model.faces()[a], &second = model.faces()[b];
      if (!faces[a].measured || !faces[b].measured || !faces[a].plane || !faces[b].plane) continue;
      FaceRelation out;
      out.first = first.id;
      out.second = second.id;
      out.are_neighbours =
          std::find(first.neighbours.begin(), first.neighbours.end(), second.id) != first.neighbours.end();
      out.are_parallel = is_parallel(first.normal, second.normal);
      if (!out.are_neighbours && !out.are_parallel) continue;
      relate_angle(first, second, *faces[a].plane, *faces[b].plane, out);
      if (out.are_parallel) relate_distance(first, second, *faces[a].plane, *faces[b].plane, out);
      relations.push_back(out);
    }
  }
  return relations;
}

}  // namespace tetragauge
