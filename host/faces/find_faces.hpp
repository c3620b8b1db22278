// SPDX-License-Identifier: GPL-3.0-or-later
// From the surface to the real faces of the part, each fitted to all its raw points (DESIGN section 5,
// "Faces").
#pragma once

#include <cstdint>
#include <vector>

#include "host/base/result.hpp"
#include "host/geometry/face.hpp"
#include "host/reconstruct/reconstruct.hpp"
#include "host/scan/scan.hpp"

namespace tetragauge {

struct FindFacesOptions {
  size_t min_points = 30;  // fewer raw points are not a face
};

struct MeasuredFaces {
  FaceList list;  // part frame; canonical order: area descending, then centroid
  std::vector<std::vector<uint32_t>> face_points;     // for each face its raw points, ascending
  std::vector<std::vector<uint32_t>> face_triangles;  // for each face its surface triangles, ascending
  std::vector<double> rms_mm;                         // residual across the plane, per face
  size_t points_used = 0,
         points_rejected = 0;  // rejected: on no face (edges, false chamfers, outliers, curved)
  size_t false_chamfers_dropped = 0;

  const std::vector<Face>& faces() const { return list.faces; }
};

Result<MeasuredFaces> find_faces(const Scan& scan, const Reconstruction& reconstruction,
                                 const FindFacesOptions& options = {});

}  // namespace tetragauge
