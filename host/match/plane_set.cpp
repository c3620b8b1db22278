// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/plane_set.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetragauge {
namespace {

// The frame u, v exactly across the normal, with u x v = normal; a tilt about -v is minus a tilt about v.
PlaneCovariance right_handed(PlaneCovariance covariance, const Vec3& normal) {
  covariance.u = (covariance.u - normal * normal.dot(covariance.u)).normalized();
  const Vec3 v = normal.cross(covariance.u);
  if (v.dot(covariance.v) < 0) {
    const Vec3 sign(1, 1, -1);
    covariance.matrix = sign.asDiagonal() * covariance.matrix * sign.asDiagonal();
  }
  covariance.v = v;
  return covariance;
}

// Indices by area, descending; equal areas by place in the list.
std::vector<size_t> by_area(const std::vector<MatchPlane>& planes) {
  std::vector<size_t> order(planes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return planes[a].area_mm2 > planes[b].area_mm2; });
  return order;
}

void find_directions(PlaneSet& set, double direction_rad) {
  const double cosine = std::cos(direction_rad);
  std::vector<Vec3> first;  // of each direction the largest face's normal
  for (const size_t i : by_area(set.planes)) {
    MatchPlane& plane = set.planes[i];
    const auto same = std::find_if(first.begin(), first.end(),
                                   [&](const Vec3& normal) { return normal.dot(plane.normal) > cosine; });
    plane.direction = static_cast<int>(same - first.begin());
    if (same == first.end()) {
      first.push_back(plane.normal);
      set.directions.emplace_back();
    }
    PlaneDirection& direction = set.directions[static_cast<size_t>(plane.direction)];
    direction.normal += plane.area_mm2 * plane.normal;
    direction.area_mm2 += plane.area_mm2;
    direction.weight += plane.weight;
  }
  for (PlaneDirection& direction : set.directions) direction.normal.normalize();

  std::vector<int> order(set.directions.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return set.directions[static_cast<size_t>(a)].area_mm2 > set.directions[static_cast<size_t>(b)].area_mm2;
  });
  std::vector<PlaneDirection> sorted;
  std::vector<int> place(order.size());
  for (size_t k = 0; k < order.size(); ++k) {
    sorted.push_back(set.directions[static_cast<size_t>(order[k])]);
    place[static_cast<size_t>(order[k])] = static_cast<int>(k);
  }
  set.directions = std::move(sorted);
  for (MatchPlane& plane : set.planes) plane.direction = place[static_cast<size_t>(plane.direction)];
  set.direction_rad = direction_rad;
  set.planes_along.resize(set.directions.size());
  for (size_t i = 0; i < set.planes.size(); ++i)
    set.planes_along[static_cast<size_t>(set.planes[i].direction)].push_back(i);
}

// Faces that the list itself cannot tell apart as planes: one degree in 600 and a hundred-thousandth of the
// size are far below what any machine of ours resolves, and far above the rounding of printed lists.
void find_groups(PlaneSet& set) {
  for (size_t i = 0; i < set.planes.size(); ++i) {
    MatchPlane& plane = set.planes[i];
    plane.group = -1;
    for (size_t k = 0; k < i && plane.group < 0; ++k) {
      const MatchPlane& other = set.planes[k];
      if (plane.normal.dot(other.normal) > 1 - 4e-10 &&
          std::abs(other.normal.dot(plane.point_mm) - other.d_mm) < 1e-5 * set.size_mm)
        plane.group = other.group;
    }
    if (plane.group < 0) {
      plane.group = static_cast<int>(set.group_area_mm2.size());
      set.group_area_mm2.push_back(0);
    }
    set.group_area_mm2[static_cast<size_t>(plane.group)] += plane.area_mm2;
  }
}

}  // namespace

Vec3 plane_centre(const std::vector<MatchPlane>& planes) {
  Mat3 normal_equations = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const MatchPlane& plane : planes) {
    normal_equations += plane.normal * plane.normal.transpose();
    right += plane.d_mm * plane.normal;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(normal_equations);
  Vec3 centre = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = eigen.eigenvectors().col(k);
    const double weight = eigen.eigenvalues()[k];
    if (weight > 1e-4 * eigen.eigenvalues()[2]) centre += axis * (axis.dot(right) / weight);
  }
  return centre;
}

PlaneSet plane_set(const FaceList& list, double direction_rad) {
  PlaneSet set;
  double all_area_mm2 = 0;
  bool some_point = false;
  for (const Face& face : list.faces) {
    if (std::isfinite(face.area_mm2)) all_area_mm2 += std::max(0.0, face.area_mm2);
    if (face.type != SurfaceType::plane) {
      set.other_ids.push_back(face.id);
      continue;
    }
    MatchPlane plane;
    plane.id = face.id;
    plane.normal = face.normal.normalized();
    plane.d_mm = face.d_mm / face.normal.norm();
    plane.point_mm = face.point_mm;
    // A list without centroids gives the foot of the origin on each plane.
    if ((plane.point_mm - plane.d_mm * plane.normal).norm() > 1e-9 * std::abs(plane.d_mm)) some_point = true;
    plane.area_mm2 = std::isfinite(face.area_mm2) ? std::max(0.0, face.area_mm2) : 0;
    if (!plane.normal.allFinite() || !std::isfinite(plane.d_mm)) continue;
    if (face.covariance) {
      plane.has_covariance = true;
      plane.covariance = right_handed(*face.covariance, plane.normal);
    } else {
      std::tie(plane.covariance.u, plane.covariance.v) = tangent_frame(plane.normal);
    }
    set.planes.push_back(plane);
  }
  std::sort(set.other_ids.begin(), set.other_ids.end());
  set.has_areas = all_area_mm2 > 0;
  if (!set.has_areas)
    for (MatchPlane& plane : set.planes) plane.area_mm2 = 1;
  double largest_mm2 = 0;
  for (const MatchPlane& plane : set.planes) largest_mm2 = std::max(largest_mm2, plane.area_mm2);
  for (MatchPlane& plane : set.planes) {
    plane.weight = largest_mm2 > 0 ? face_weight(plane.area_mm2, largest_mm2) : 0;
    set.area_mm2 += plane.area_mm2;
    set.weight += plane.weight;
  }

  set.has_centroids = some_point;
  if (!set.has_centroids) {
    const Vec3 centre = plane_centre(set.planes);
    for (MatchPlane& plane : set.planes)
      plane.point_mm = centre + plane.normal * (plane.d_mm - plane.normal.dot(centre));
  }
  for (const MatchPlane& plane : set.planes)
    set.centroid_mm += plane.point_mm * (plane.area_mm2 / set.area_mm2);
  set.pivot_mm = set.centroid_mm;

  // The diagonal of a cube of that area, or of the box round the centroids where that is longer (bars);
  // without areas twice the reach of the planes.
  if (set.has_areas) set.size_mm = std::sqrt(all_area_mm2 / 2);
  Vec3 low = set.centroid_mm, high = set.centroid_mm;
  double reach_mm = 0;
  for (const MatchPlane& plane : set.planes) {
    low = low.cwiseMin(plane.point_mm);
    high = high.cwiseMax(plane.point_mm);
    reach_mm = std::max(reach_mm, (plane.point_mm - set.centroid_mm).norm());
  }
  if (set.has_centroids) {
    set.size_mm = std::max(set.size_mm, (high - low).norm());
  } else if (!set.has_areas) {
    set.size_mm = 2 * reach_mm;
  }
  find_directions(set, direction_rad);
  find_groups(set);
  return set;
}

}  // namespace tetragauge
