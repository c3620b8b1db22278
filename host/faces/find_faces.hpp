// SPDX-License-Identifier: GPL-3.0-or-later
// From the surface to the real faces of the part, each fitted to all its raw points (DESIGN section 5,
// "Faces").
#pragma once

#include <cstdint>
#include <vector>

#include "host/base/result.hpp"
#include "host/faces/cluster_facets.hpp"
#include "host/faces/trace_boundaries.hpp"
#include "host/geometry/face.hpp"
#include "host/reconstruct/reconstruct.hpp"
#include "host/scan/scan.hpp"

namespace tetragauge {

// How triangles and vertices first come together; the fit to the raw points is the same for all.
enum class ClusterMethod {
  grow,     // regions from the flattest neighbourhoods outwards
  normals,  // the thesis's: scalar products of normals, mid-planes of parallel faces
  slink     // the thesis's: single link on the hypercylinder
};

struct FindFacesOptions {
  size_t min_points = 30;  // fewer raw points are not a face
  ClusterMethod cluster = ClusterMethod::grow;
  double neighbour_weight = 1;  // normals, slink: of the neighbours in the correction of a triangle's normal
  SingleLinkOptions single_link;  // slink
};

struct MeasuredFaces {
  FaceList list;  // part frame; canonical order: area descending, then centroid
  std::vector<std::vector<uint32_t>> face_points;     // for each face its raw points, ascending
  std::vector<std::vector<uint32_t>> face_triangles;  // for each face its surface triangles, ascending
  std::vector<double> rms_mm;                         // residual across the plane, per face
  // The boundary model: for each face its loops, edges where planes meet, `beyond` counting from 0 like
  // faces() (see trace_boundaries.hpp), and the volume inside.
  std::vector<std::vector<BoundaryLoop>> boundaries;
  double volume_mm3 = 0;
  size_t points_used = 0,
         points_rejected = 0;  // rejected: on no face (edges, false chamfers, outliers, curved)
  size_t false_chamfers_dropped = 0;
  size_t coplanar_clusters = 0;  // normals, slink: before they are split into connected patches
  Dendrogram dendrogram;         // slink

  const std::vector<Face>& faces() const { return list.faces; }
};

Result<MeasuredFaces> find_faces(const Scan& scan, const Reconstruction& reconstruction,
                                 const FindFacesOptions& options = {});

}  // namespace tetragauge
