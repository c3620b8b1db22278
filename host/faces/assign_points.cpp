// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/assign_points.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "host/faces/compare_planes.hpp"
#include "host/geometry/fit_plane_along_rays.hpp"
#include "host/reconstruct/average_points.hpp"

namespace tetragauge {
namespace {

constexpr double kGate = 3;        // sigma
constexpr double kFacing = -0.02;  // rays run against the normal of what they hit
// Planes that turn by less than half a degree, or by less than five of their own uncertainties, meet in no
// edge that a ray could tell: there the nearer one wins. Before they are fitted, by less than 10 degrees.
constexpr double kFlattestEdge_rad = 0.0087, kSureTurn = 5, kFlatBeforeFit_rad = 0.174;

// How two faces meet: at a convex edge each ends where it enters the other's outside, at a concave one where
// it enters the other's material.
enum class Edge { unknown, convex, concave };

class Assigner {
 public:
  Assigner(const Scan& scan, const Reconstruction& reconstruction, const SurfaceGraph& graph, Regions regions,
           size_t min_points)
      : scan_(scan),
        reconstruction_(reconstruction),
        graph_(graph),
        min_points_(min_points),
        band_mm_(0.15 * reconstruction.point_spacing_mm),
        sigma_mm_(floored_sigma_mm(scan)),
        planes_(std::move(regions.planes)),
        scale_(planes_.size(), 1.0),
        vertex_face_(std::move(regions.vertex_region)),
        point_face_(scan.size(), kNoRegion),
        point_side_(scan.size(), kNoRegion) {}

  FittedFaces run(int rounds) {
    for (int round = 0; round < rounds; ++round) {
      flood();
      find_candidates();
      find_edges();
      const bool changed = assign();
      fit();
      const bool dropped = drop_small();
      relabel_vertices();
      if (!changed && !dropped) break;
    }
    return {std::move(fits_), std::move(point_face_), std::move(point_side_), std::move(vertex_face_)};
  }

 private:
  // Faces spread over the vertices around them that belong to none, as far as their points would be let in.
  void flood() {
    const double points_per_vertex =
        std::max(1.0, std::pow(reconstruction_.vertex_spacing_mm / reconstruction_.point_spacing_mm, 2));
    std::vector<uint32_t> queue;
    for (uint32_t v = 0; v < graph_.size(); ++v) {
      if (vertex_face_[v] != kNoRegion) queue.push_back(v);
    }
    for (size_t at = 0; at < queue.size(); ++at) {
      const int32_t f = vertex_face_[queue[at]];
      const Plane& plane = planes_[static_cast<size_t>(f)];
      for (uint32_t n : graph_.around(queue[at])) {
        if (vertex_face_[n] != kNoRegion) continue;
        const Vec3& ray = reconstruction_.vertex_ray[n];
        if (plane.normal.dot(ray) > kFacing) continue;
        const double sigma = std::sqrt(points_per_vertex) * scale_[static_cast<size_t>(f)] *
                             sigma_across(reconstruction_.vertex_sigma_mm[n], ray, plane.normal);
        if (std::abs(plane.distance(reconstruction_.vertices[n])) > kGate * sigma) continue;
        vertex_face_[n] = f;
        queue.push_back(n);
      }
    }
  }

  // Faces within two edges of each vertex: those next to it, and those next to its neighbours. Nearly all
  // vertices lie deep in one face; only the others get a list.
  void find_candidates() {
    std::vector<uint8_t> mixed(graph_.size(), 0);
    for (uint32_t v = 0; v < graph_.size(); ++v) {
      for (uint32_t n : graph_.around(v)) {
        if (vertex_face_[n] != vertex_face_[v]) mixed[v] = 1;
      }
    }
    candidates_.clear();
    candidate_list_.assign(graph_.size(), kOwnFaceOnly);
    for (uint32_t v = 0; v < graph_.size(); ++v) {
      const auto around = graph_.around(v);
      if (!mixed[v] && std::none_of(around.begin(), around.end(), [&](uint32_t n) { return mixed[n] != 0; }))
        continue;
      candidate_list_[v] = static_cast<uint32_t>(candidates_.size());
      std::vector<int32_t>& near = candidates_.emplace_back();
      add_face(near, vertex_face_[v]);
      for (uint32_t n : around) {
        add_face(near, vertex_face_[n]);
        for (uint32_t m : graph_.around(n)) add_face(near, vertex_face_[m]);
      }
      std::sort(near.begin(), near.end());
    }
  }

  std::span<const int32_t> candidates(uint32_t v) const {
    if (candidate_list_[v] != kOwnFaceOnly) return candidates_[candidate_list_[v]];
    if (vertex_face_[v] == kNoRegion) return {};
    return {&vertex_face_[v], 1};
  }

  static void add_face(std::vector<int32_t>& faces, int32_t face) {
    if (face != kNoRegion && std::find(faces.begin(), faces.end(), face) == faces.end())
      faces.push_back(face);
  }

  // Whether two planes are surely not parallel.
  bool meet(size_t f, size_t g) const {
    const double turn = planes_[f].normal.cross(planes_[g].normal).norm();
    if (fits_.empty()) return turn > kFlatBeforeFit_rad;
    const auto variance = [&](size_t k) {
      return fits_[k].covariance.matrix.diagonal().tail<2>().maxCoeff();
    };
    return turn > std::max(kFlattestEdge_rad, kSureTurn * std::sqrt(variance(f) + variance(g)));
  }

  // The sides on which two faces lie of one another, where they are near one another.
  void find_edges() {
    std::map<std::pair<int32_t, int32_t>, std::pair<size_t, size_t>> sides;  // inside, outside the other
    for (uint32_t v = 0; v < graph_.size(); ++v) {
      const int32_t f = vertex_face_[v];
      if (f == kNoRegion) continue;
      for (int32_t g : candidates(v)) {
        if (g == f) continue;
        const Plane& other = planes_[static_cast<size_t>(g)];
        const double distance = other.distance(reconstruction_.vertices[v]);
        const double sigma =
            sigma_across(reconstruction_.vertex_sigma_mm[v], reconstruction_.vertex_ray[v], other.normal);
        if (std::abs(distance) < kGate * sigma) continue;
        auto& count = sides[std::minmax(f, g)];
        ++(distance < 0 ? count.first : count.second);
      }
    }
    edges_.clear();
    for (const auto& [pair, count] : sides) {
      if (!meet(static_cast<size_t>(pair.first), static_cast<size_t>(pair.second))) continue;
      const size_t all = count.first + count.second;
      Edge edge = Edge::unknown;
      if (5 * count.first >= 4 * all) edge = Edge::convex;
      if (5 * count.second >= 4 * all) edge = Edge::concave;
      edges_[pair] = edge;
    }
  }

  Edge edge_between(int32_t f, int32_t g) const {
    const auto found = edges_.find(std::minmax(f, g));
    return found == edges_.end() ? Edge::unknown : found->second;
  }

  // |distance| in sigma of raw point i from face f; beyond the gate if its ray could not have seen f.
  double deviation(uint32_t i, int32_t f) const {
    const Plane& plane = planes_[static_cast<size_t>(f)];
    const Vec3 ray = scan_.ray_direction(i);
    if (plane.normal.dot(ray) > kFacing) return 2 * kGate;
    return std::abs(plane.distance(scan_.points[i])) /
           (scale_[static_cast<size_t>(f)] * sigma_across(sigma_mm_[i], ray, plane.normal));
  }

  enum class Hold { no, in_band, yes };

  // Whether a point within the gate of f may be f's in view of neighbouring face g.
  Hold holds_against(uint32_t i, int32_t f, double z_f, int32_t g) const {
    const Plane &own = planes_[static_cast<size_t>(f)], &other = planes_[static_cast<size_t>(g)];
    const double cosine = own.normal.dot(other.normal);
    const double z_g = deviation(i, g);
    const Edge edge = edge_between(f, g);
    const auto hold = [](bool holds) { return holds ? Hold::yes : Hold::no; };
    if (edge == Edge::unknown) return hold(z_g > kGate || z_f < z_g || (z_f == z_g && f < g));
    const Vec3 ray = scan_.ray_direction(i);
    const Vec3 hit = scan_.points[i] - ray * (own.distance(scan_.points[i]) / own.normal.dot(ray));
    const double outside = other.distance(hit) / std::sqrt(1 - cosine * cosine);  // from the edge, in f
    const Hold side = hold(z_g > kGate || (edge == Edge::convex ? outside < 0 : outside > 0));
    return side == Hold::yes && std::abs(outside) < band_mm_ ? Hold::in_band : side;
  }

  struct Assignment {
    int32_t face = kNoRegion;  // whose fit it takes part in
    int32_t side = kNoRegion;  // whose side of the edges it lies on, band or not
  };

  Assignment assignment_of(uint32_t i) const {
    Assignment best;
    double best_z = kGate, best_side_z = kGate;
    const std::span<const int32_t> near = candidates(reconstruction_.point_vertex[i]);
    for (int32_t f : near) {
      const double z = deviation(i, f);
      if (!(z <= best_z) && !(z <= best_side_z)) continue;
      Hold hold = Hold::yes;
      for (int32_t g : near) {
        if (g != f) hold = std::min(hold, holds_against(i, f, z, g));
      }
      if (hold == Hold::yes && z <= best_z) {
        best.face = f;
        best_z = z;
      }
      if (hold != Hold::no && z <= best_side_z) {
        best.side = f;
        best_side_z = z;
      }
    }
    return best;
  }

  bool assign() {
    std::vector<Assignment> assigned(scan_.size());
    tbb::parallel_for(tbb::blocked_range<uint32_t>(0, static_cast<uint32_t>(scan_.size()), 4096),
                      [&](const auto& range) {
                        for (uint32_t i = range.begin(); i < range.end(); ++i) assigned[i] = assignment_of(i);
                      });
    bool changed = false;
    for (uint32_t i = 0; i < scan_.size(); ++i) {
      changed = changed || assigned[i].face != point_face_[i];
      point_face_[i] = assigned[i].face;
      point_side_[i] = assigned[i].side;
    }
    return changed;
  }

  void fit() {
    std::vector<std::vector<uint32_t>> members(planes_.size());
    std::vector<size_t> on_its_side(planes_.size(), 0);
    for (uint32_t i = 0; i < scan_.size(); ++i) {
      if (point_face_[i] != kNoRegion) members[static_cast<size_t>(point_face_[i])].push_back(i);
      if (point_side_[i] != kNoRegion) ++on_its_side[static_cast<size_t>(point_side_[i])];
    }
    fits_.assign(planes_.size(), {});
    tbb::parallel_for(size_t{0}, planes_.size(), [&](size_t f) {
      // Points in the band lie on the face too; they only do not take part in its fit.
      if (on_its_side[f] < min_points_ || 2 * members[f].size() < min_points_) return;
      const auto fitted = fit_members(scan_, sigma_mm_, members[f], planes_[f].normal);
      if (!fitted) return;
      fits_[f] = *fitted;
      planes_[f] = {fitted->normal, fitted->d_mm};
      scale_[f] = noise_scale(*fitted);
    });
  }

  bool drop_small() {
    std::vector<int32_t> new_index(planes_.size(), kNoRegion);
    int32_t kept = 0;
    for (size_t f = 0; f < planes_.size(); ++f) {
      if (fits_[f].points == 0) continue;
      new_index[f] = kept;
      planes_[static_cast<size_t>(kept)] = planes_[f];
      fits_[static_cast<size_t>(kept)] = fits_[f];
      scale_[static_cast<size_t>(kept)] = scale_[f];
      ++kept;
    }
    const bool dropped = static_cast<size_t>(kept) != planes_.size();
    planes_.resize(static_cast<size_t>(kept));
    fits_.resize(static_cast<size_t>(kept));
    scale_.resize(static_cast<size_t>(kept));
    const auto renumber = [&](int32_t& f) {
      if (f != kNoRegion) f = new_index[static_cast<size_t>(f)];
    };
    std::for_each(point_face_.begin(), point_face_.end(), renumber);
    std::for_each(point_side_.begin(), point_side_.end(), renumber);
    std::for_each(vertex_face_.begin(), vertex_face_.end(), renumber);
    return dropped;
  }

  // A vertex goes with its points; one whose points are all in the band stays where it was if it still fits.
  void relabel_vertices() {
    // Nearly all vertices have points of one face only; the others vote.
    std::vector<int32_t> only(graph_.size(), kNoRegion);
    std::vector<uint8_t> is_mixed(graph_.size(), 0);
    for (uint32_t i = 0; i < scan_.size(); ++i) {
      const uint32_t v = reconstruction_.point_vertex[i];
      if (point_face_[i] == kNoRegion) continue;
      if (only[v] == kNoRegion) only[v] = point_face_[i];
      is_mixed[v] |= only[v] != point_face_[i];
    }
    std::map<uint32_t, std::vector<int32_t>> votes;
    for (uint32_t i = 0; i < scan_.size(); ++i) {
      const uint32_t v = reconstruction_.point_vertex[i];
      if (is_mixed[v] && point_face_[i] != kNoRegion) votes[v].push_back(point_face_[i]);
    }
    for (auto& [v, faces] : votes) {
      std::sort(faces.begin(), faces.end());
      only[v] = most_frequent(faces);
    }
    for (uint32_t v = 0; v < graph_.size(); ++v) {
      if (only[v] != kNoRegion) {
        vertex_face_[v] = only[v];
        continue;
      }
      const int32_t f = vertex_face_[v];
      if (f == kNoRegion) continue;
      const Plane& plane = planes_[static_cast<size_t>(f)];
      const double sigma =
          sigma_across(reconstruction_.vertex_sigma_mm[v], reconstruction_.vertex_ray[v], plane.normal);
      if (std::abs(plane.distance(reconstruction_.vertices[v])) > kGate * sigma) vertex_face_[v] = kNoRegion;
    }
  }

  static int32_t most_frequent(const std::vector<int32_t>& sorted) {
    int32_t best = sorted.front();
    size_t best_count = 0;
    for (size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
      while (end < sorted.size() && sorted[end] == sorted[begin]) ++end;
      if (end - begin > best_count) {
        best_count = end - begin;
        best = sorted[begin];
      }
    }
    return best;
  }

  const Scan& scan_;
  const Reconstruction& reconstruction_;
  const SurfaceGraph& graph_;
  size_t min_points_;
  double band_mm_;
  std::vector<double> sigma_mm_;
  std::vector<Plane> planes_;
  std::vector<PlaneFit> fits_;
  std::vector<double> scale_;  // of each face's gate: noise_scale()
  std::vector<int32_t> vertex_face_, point_face_, point_side_;
  static constexpr uint32_t kOwnFaceOnly = UINT32_MAX;
  std::vector<uint32_t> candidate_list_;  // per vertex, into candidates_
  std::vector<std::vector<int32_t>> candidates_;
  std::map<std::pair<int32_t, int32_t>, Edge> edges_;
};

}  // namespace

std::optional<PlaneFit> fit_members(const Scan& scan, const std::vector<double>& sigma_mm,
                                    const std::vector<uint32_t>& members, const Vec3& normal) {
  std::vector<Vec3> points, directions;
  std::vector<double> weights;
  points.reserve(members.size());
  directions.reserve(members.size());
  weights.reserve(members.size());
  for (uint32_t i : members) {
    points.push_back(scan.points[i]);
    directions.push_back(scan.ray_direction(i));
    const double s = sigma_across(sigma_mm[i], directions.back(), normal);
    weights.push_back(1 / (s * s));
  }
  return fit_plane_along_rays(points, directions, weights, normal);
}

FittedFaces assign_points(const Scan& scan, const Reconstruction& reconstruction, const SurfaceGraph& graph,
                          Regions regions, size_t min_points, int rounds) {
  return Assigner(scan, reconstruction, graph, std::move(regions), min_points).run(rounds);
}

}  // namespace tetragauge
