// SPDX-License-Identifier: GPL-3.0-or-later
// The thesis's own two ways from triangles to faces (Cakir, Bath 1989, chapter 6), as seeds for the fit to
// the raw points.
#pragma once

#include <optional>

#include "host/base/result.hpp"
#include "host/faces/grow_regions.hpp"
#include "host/faces/single_link.hpp"
#include "host/faces/triangle_normals.hpp"

namespace tetragauge {

constexpr uint32_t kNoCluster = UINT32_MAX;

// One cluster holds what lies on one plane, connected or not.
struct FacetClusters {
  std::vector<uint32_t> cluster;  // per element, kNoCluster: doubtful, in none
  uint32_t count = 0;
};

// By scalar products of normals; parallel faces are then parted by their mid-planes.
FacetClusters cluster_by_normals(const std::vector<FacetElement>& elements);

struct SingleLinkOptions {
  double height = 0;  // where to cut the dendrogram; 0: from the noise of the normals
  size_t count = 0;   // or cut it where it has this many clusters
};

// By single link on the hypercylinder: a triangle's plane is a point of the unit sphere (its normal) times a
// line (its distance from the part's middle, in units of the part's radius); the dissimilarity is the
// distance along that surface, in radians. Error (usage): more triangles than the square of time allows, or
// no height with so many clusters.
Result<FacetClusters> cluster_by_single_link(const std::vector<FacetElement>& elements,
                                             const SingleLinkOptions& options, Dendrogram& dendrogram);

// Each connected patch of a cluster is the seed of a face.
Regions regions_of_clusters(const Reconstruction& reconstruction, const std::vector<FacetElement>& elements,
                            const FacetClusters& clusters);

}  // namespace tetragauge
