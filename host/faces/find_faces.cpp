// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/find_faces.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "host/faces/assign_points.hpp"
#include "host/faces/compare_planes.hpp"
#include "host/faces/face_boundaries.hpp"
#include "host/faces/grow_regions.hpp"
#include "host/faces/select_faces.hpp"
#include "host/faces/split_creased.hpp"
#include "host/faces/surface_graph.hpp"
#include "host/faces/unite_patches.hpp"
#include "host/reconstruct/average_points.hpp"
#include "host/scan/pick_points.hpp"

namespace tetragauge {
namespace {

// Area descending, then centroid: the same for any order of the points.
std::vector<size_t> canonical_face_order(const FaceExtents& extents, std::vector<size_t> order) {
  const auto key = [&](size_t f) {
    const FaceExtent& e = extents.faces[f];
    return std::tuple(-e.area_mm2, e.centroid_mm.x(), e.centroid_mm.y(), e.centroid_mm.z());
  };
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return key(a) < key(b); });
  return order;
}

// Faces whose planes the data cannot tell apart share a surface.
void number_surfaces(std::vector<Face>& faces, const std::vector<PlaneFit>& fits) {
  int surfaces = 0;
  for (size_t f = 0; f < faces.size(); ++f) {
    for (size_t g = 0; g < f && faces[f].surface == 0; ++g) {
      if (fits[f].normal.dot(fits[g].normal) > 0 && plane_chi2(fits[g], fits[f]) < kSamePlaneChi2)
        faces[f].surface = faces[g].surface;
    }
    if (faces[f].surface == 0) faces[f].surface = ++surfaces;
  }
}

// `faces`: those large enough to be reported. The others only bound them.
MeasuredFaces describe(const Scan& scan, const FittedFaces& fitted, FaceExtents extents,
                       const std::vector<size_t>& faces) {
  MeasuredFaces result;
  const std::vector<size_t> order = canonical_face_order(extents, faces);
  constexpr int kNone = 0;
  std::vector<int> id(fitted.fits.size(), kNone);
  for (size_t k = 0; k < order.size(); ++k) id[order[k]] = static_cast<int>(k) + 1;

  std::vector<PlaneFit> fits;
  for (size_t f : order) {
    const PlaneFit& fit = fitted.fits[f];
    Face face;
    face.id = id[f];
    face.normal = fit.normal;
    face.d_mm = fit.d_mm;
    face.point_mm = extents.faces[f].centroid_mm;
    face.area_mm2 = extents.faces[f].area_mm2;
    face.covariance = covariance_at(fit, face.point_mm);
    face.covariance->matrix *= std::pow(noise_scale(fit), 2);
    for (size_t g : extents.faces[f].neighbours) {
      if (id[g] != kNone) face.neighbours.push_back(id[g]);
    }
    std::sort(face.neighbours.begin(), face.neighbours.end());
    face.points = fit.points;
    result.list.faces.push_back(std::move(face));
    result.face_triangles.push_back(std::move(extents.faces[f].triangles));
    for (BoundaryLoop& loop : extents.faces[f].loops) {
      for (BoundaryEdge& edge : loop) {
        if (edge.beyond == kNoRegion) continue;
        const int beyond = id[static_cast<size_t>(edge.beyond)];
        edge.beyond = beyond == kNone ? kNoRegion : beyond - 1;
      }
    }
    result.boundaries.push_back(std::move(extents.faces[f].loops));
    fits.push_back(fit);
  }
  number_surfaces(result.list.faces, fits);

  result.face_points.resize(order.size());
  result.rms_mm.assign(order.size(), 0);
  for (uint32_t i = 0; i < scan.size(); ++i) {
    const int32_t f = fitted.point_face[i];
    if (f == kNoRegion || id[static_cast<size_t>(f)] == kNone) continue;
    const auto k = static_cast<size_t>(id[static_cast<size_t>(f)] - 1);
    result.face_points[k].push_back(i);
    result.rms_mm[k] += std::pow(fits[k].normal.dot(scan.points[i]) - fits[k].d_mm, 2);
    ++result.points_used;
  }
  for (size_t k = 0; k < order.size(); ++k)
    result.rms_mm[k] = std::sqrt(result.rms_mm[k] / static_cast<double>(fits[k].points));
  result.volume_mm3 = extents.volume_mm3;
  result.points_rejected = scan.size() - result.points_used;
  return result;
}

Result<Regions> cluster(const Reconstruction& reconstruction, const FindFacesOptions& options,
                        MeasuredFaces& result) {
  const std::vector<FacetElement> elements = facet_elements(reconstruction, options.neighbour_weight);
  FacetClusters clusters;
  if (options.cluster == ClusterMethod::normals) {
    clusters = cluster_by_normals(elements);
  } else {
    Result<FacetClusters> linked = cluster_by_single_link(elements, options.single_link, result.dendrogram);
    if (!linked) return linked.error();
    clusters = *std::move(linked);
  }
  result.coplanar_clusters = clusters.count;
  return regions_of_clusters(reconstruction, elements, clusters);
}

// Two planes at a small angle may have grown far enough into what was taken for a piece of a curve to show
// their crease. They are planes if, fitted by themselves, they end at edges; halves of a strip of a cylinder
// go on at both sides, as the whole did.
std::optional<Regions> part_at_creases(const Scan& scan, const Reconstruction& reconstruction,
                                       const SurfaceGraph& graph, const FittedFaces& rough,
                                       const std::vector<size_t>& curved, size_t few_points, int few_turns) {
  const Creased creased = split_creased(scan, reconstruction, rough, curved);
  if (creased.parted.empty()) return std::nullopt;
  const FittedFaces apart =
      assign_points(scan, reconstruction, graph, creased.regions, few_points, few_turns);
  // The face that now holds most of a region's vertices.
  const auto fitted_to = [&](size_t region) {
    std::vector<size_t> votes(apart.fits.size(), 0);
    for (size_t v = 0; v < graph.size(); ++v) {
      if (creased.regions.vertex_region[v] == static_cast<int32_t>(region) &&
          apart.vertex_face[v] != kNoRegion)
        ++votes[static_cast<size_t>(apart.vertex_face[v])];
    }
    const auto most = std::max_element(votes.begin(), votes.end());
    return most == votes.end() || *most == 0 ? kNoRegion : static_cast<int32_t>(most - votes.begin());
  };
  const auto ends_at_edges = [&](int32_t f, int32_t other_half) {
    return soft_rim_share(reconstruction, graph, apart, static_cast<size_t>(f), other_half) <=
           kGoesOnBothSides;
  };
  std::vector<size_t> proven;
  for (size_t k = 0; k < creased.parted.size(); ++k) {
    const int32_t first = fitted_to(creased.parted[k]), second = fitted_to(rough.fits.size() + k);
    if (first == kNoRegion || second == kNoRegion || first == second) continue;
    if (ends_at_edges(first, second) && ends_at_edges(second, first)) proven.push_back(creased.parted[k]);
  }
  if (proven.empty()) return std::nullopt;
  return split_creased(scan, reconstruction, rough, proven).regions;
}

// Of a scan whose points are in canonical order, so that sums over them have the same last bit.
Result<MeasuredFaces> find_in_order(const Scan& scan, const Reconstruction& reconstruction,
                                    const FindFacesOptions& options) {
  const SurfaceGraph graph = surface_graph(reconstruction);
  // Averaged vertices are fewer than points: a region of few vertices may still hold enough points.
  constexpr size_t kMinVertices = 6;
  // While the set of faces still changes, a few turns do, and few points: crumbs of a narrow face are united
  // before they are counted. The last fit goes to a fixed point.
  constexpr int kRounds = 20, kFewTurns = 3, kAllTurns = 20;
  constexpr size_t kFewPoints = 8;
  MeasuredFaces clustered;
  Regions regions;
  if (options.cluster == ClusterMethod::grow) {
    regions = grow_regions(reconstruction, graph, kMinVertices);
  } else {
    Result<Regions> seeds = cluster(reconstruction, options, clustered);
    if (!seeds) return seeds.error();
    regions = *std::move(seeds);
  }
  {
    const FittedFaces grown =
        assign_points(scan, reconstruction, graph, std::move(regions), kFewPoints, kFewTurns);
    std::vector<size_t> all(grown.fits.size());
    std::iota(all.begin(), all.end(), size_t{0});
    regions = split_creased(scan, reconstruction, grown, all).regions;
  }
  size_t false_chamfers = 0;
  for (int round = 0; round < kRounds; ++round) {
    const FittedFaces rough = assign_points(scan, reconstruction, graph, regions, kFewPoints, kFewTurns);
    Selection selection = select_faces(scan, reconstruction, graph, rough);
    if (!selection.curved.empty()) {
      if (auto parted =
              part_at_creases(scan, reconstruction, graph, rough, selection.curved, kFewPoints, kFewTurns)) {
        regions = *std::move(parted);
        continue;
      }
    }
    false_chamfers += selection.false_chamfers;
    regions = std::move(selection.regions);
    if (!selection.changed) break;
  }
  // Faces of few points are not reported, but the boundary model needs their planes: without them the edges
  // and corners of their neighbours would be cut off as the mesh cuts them.
  FittedFaces fitted = assign_points(scan, reconstruction, graph, std::move(regions), kFewPoints, kAllTurns);
  fitted = split_unconnected(scan, reconstruction, graph, std::move(fitted), kFewPoints, options.min_points);
  fitted = unite_patches(scan, reconstruction, std::move(fitted), options.min_points);

  FaceExtents extents = face_extents(reconstruction, graph, fitted);
  false_chamfers += extents.strips;
  MeasuredFaces result = describe(scan, fitted, std::move(extents),
                                  reportable(scan, reconstruction, fitted, options.min_points));
  result.false_chamfers_dropped = false_chamfers;
  result.coplanar_clusters = clustered.coplanar_clusters;
  result.dendrogram = std::move(clustered.dendrogram);
  return result;
}

}  // namespace

Result<MeasuredFaces> find_faces(const Scan& scan, const Reconstruction& reconstruction,
                                 const FindFacesOptions& options) {
  if (options.min_points < 3)
    return usage_error("faces: a plane needs at least 3 points; min_points is " +
                       std::to_string(options.min_points));
  if (reconstruction.point_vertex.size() != scan.size())
    return internal_error("faces: the reconstruction belongs to another scan");
  const std::vector<uint32_t> order = canonical_order(scan);
  if (std::is_sorted(order.begin(), order.end())) return find_in_order(scan, reconstruction, options);
  Reconstruction sorted = reconstruction;
  for (size_t k = 0; k < order.size(); ++k) sorted.point_vertex[k] = reconstruction.point_vertex[order[k]];
  Result<MeasuredFaces> found = find_in_order(pick_points(scan, order), sorted, options);
  if (!found) return found;
  for (std::vector<uint32_t>& points : found->face_points) {
    for (uint32_t& point : points) point = order[point];
    std::sort(points.begin(), points.end());
  }
  return found;
}

}  // namespace tetragauge
