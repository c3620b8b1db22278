// SPDX-License-Identifier: GPL-3.0-or-later
// The planes of a face list, as the match sees them: unit normal, a point on the plane, area, covariance, and
// which of them lie on one plane or share a direction.
#pragma once

#include <vector>

#include "host/geometry/face.hpp"

namespace tetragauge {

// A face of a fiftieth of the largest one's area counts half: it may well be an artefact. Beyond that faces
// count alike, for one large false face must not outweigh twenty small true ones.
inline double face_weight(double area_mm2, double largest_mm2) {
  return area_mm2 / (area_mm2 + 0.02 * largest_mm2);
}

struct MatchPlane {
  int id = 0;                    // of the face
  Vec3 normal = Vec3::Zero();    // unit
  double d_mm = 0;               // normal . x = d
  Vec3 point_mm = Vec3::Zero();  // on the plane: the face's centroid, or the point nearest the plane centre
  double area_mm2 = 0;           // 1 for every face of a list without areas
  double weight = 0;             // in the search: 1 for a large face, 1/2 for a fiftieth of the largest
  bool has_covariance = false;
  PlaneCovariance covariance;  // always with u and v; matrix is zero where nothing is known
  int group = 0;               // faces on one plane share it
  int direction = 0;           // index into PlaneSet::directions
};

struct PlaneDirection {
  Vec3 normal = Vec3::Zero();  // unit, area-weighted mean
  double area_mm2 = 0, weight = 0;
};

struct PlaneSet {
  std::vector<MatchPlane> planes;
  std::vector<PlaneDirection> directions;         // by area, descending
  std::vector<std::vector<size_t>> planes_along;  // of each direction the planes, ascending
  double direction_rad = 0;                       // how far their normals may be from its largest face's
  std::vector<double> group_area_mm2;
  std::vector<int> other_ids;  // faces that are no planes, ascending
  bool has_centroids = true;   // false: the list (.hsp) names planes and areas only
  bool has_areas = true;
  double area_mm2 = 0, weight = 0;  // of the planes
  double size_mm = 0;               // about the diagonal of the part's box
  Vec3 centroid_mm = Vec3::Zero();  // area-weighted mean of the points
  Vec3 pivot_mm = Vec3::Zero();     // the pose's covariance is about it: the solid's centroid where known
};

// Faces whose normals differ by less than `direction_rad` from that of a larger face share its direction.
PlaneSet plane_set(const FaceList& list, double direction_rad);

// The thesis's plane centre: the point whose squared distances to the planes have the least sum. Along
// directions that no plane bounds it stays at the origin.
Vec3 plane_centre(const std::vector<MatchPlane>& planes);

}  // namespace tetragauge
