// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/select_faces.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "host/faces/compare_planes.hpp"
#include "host/faces/split_creased.hpp"
#include "host/reconstruct/average_points.hpp"

namespace tetragauge {
namespace {

constexpr double kGate = 3;               // sigma
constexpr double kSmoothSlope = 1.0 / 3;  // about 18 degrees

// Width of a uniform strip that scatters as these points do.
double width_mm(const Scan& scan, const PlaneFit& plane, const std::vector<uint32_t>& members) {
  if (members.empty()) return 0;
  const auto count = static_cast<double>(members.size());
  Mat3 scatter = Mat3::Zero();
  Vec3 mean = Vec3::Zero();
  for (uint32_t i : members) mean += scan.points[i] - plane.centroid_mm;
  mean /= count;
  for (uint32_t i : members) {
    const Vec3 r = scan.points[i] - plane.centroid_mm - mean;
    scatter += r * r.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(scatter / count, Eigen::EigenvaluesOnly);
  return std::sqrt(12 * std::max(0.0, eigen.eigenvalues()[1]));
}

double vertex_sigma(const Reconstruction& reconstruction, uint32_t v, const PlaneFit& plane) {
  return sigma_across(reconstruction.vertex_sigma_mm[v], reconstruction.vertex_ray[v], plane.normal);
}

// A face is at least 2 spacings wide; the bands at its edges leave it 1.5, and a row of points at spacing s
// spans less than the face by half a spacing on either side. What is narrower than that by half is no plane
// at all: two points side by side are nowhere.
constexpr double kFaceSpacings = 1, kPlaneSpacings = 0.5;

class Selector {
 public:
  Selector(const Scan& scan, const Reconstruction& reconstruction, const SurfaceGraph& graph,
           const FittedFaces& fitted)
      : scan_(scan),
        reconstruction_(reconstruction),
        graph_(graph),
        fitted_(fitted),
        sigma_mm_(floored_sigma_mm(scan)),
        members_(fitted.fits.size()),
        neighbours_(fitted.fits.size()),
        becomes_(fitted.fits.size()) {
    std::iota(becomes_.begin(), becomes_.end(), 0);
    for (uint32_t i = 0; i < scan.size(); ++i) {
      if (fitted.point_face[i] != kNoRegion) members_[static_cast<size_t>(fitted.point_face[i])].push_back(i);
    }
    find_neighbours();
  }

  Selection run() {
    Selection selection;
    unite();
    for (size_t f = 0; f < becomes_.size(); ++f) {
      if (becomes_[f] != static_cast<int32_t>(f)) continue;
      const bool chamfer = is_false_chamfer(f);
      const bool narrow =
          width_mm(scan_, fitted_.fits[f], members_[f]) < kPlaneSpacings * reconstruction_.point_spacing_mm;
      const bool curved = !chamfer && !narrow && is_curved(f);
      if (!chamfer && !narrow && !curved) continue;
      if (chamfer) ++selection.false_chamfers;
      if (curved) selection.curved.push_back(f);
      becomes_[f] = kNoRegion;
    }
    selection.regions = regions_left(selection.changed);
    return selection;
  }

 private:
  // Faces within two edges on the surface.
  void find_neighbours() {
    for (uint32_t v = 0; v < graph_.size(); ++v) {
      const int32_t f = fitted_.vertex_face[v];
      if (f == kNoRegion) continue;
      const auto add = [&](uint32_t w) {
        const int32_t g = fitted_.vertex_face[w];
        if (g != kNoRegion && g != f) neighbours_[static_cast<size_t>(f)].insert(g);
      };
      for (uint32_t n : graph_.around(v)) {
        add(n);
        for (uint32_t m : graph_.around(n)) add(m);
      }
    }
  }

  void unite() {
    for (size_t f = 0; f < becomes_.size(); ++f) {
      for (int32_t g : neighbours_[f]) {
        const auto other = static_cast<size_t>(g);
        if (other <= f || becomes_[other] != g || becomes_[f] != static_cast<int32_t>(f)) continue;
        if (fitted_.fits[f].normal.dot(fitted_.fits[other].normal) <= 0) continue;
        if (plane_chi2(fitted_.fits[f], fitted_.fits[other]) < kSamePlaneChi2 || goes_on_flat(f, other))
          becomes_[other] = static_cast<int32_t>(f);
      }
    }
  }

  // Whether two faces are pieces of one slightly bowed face: hardly turned, and without a step where they
  // meet.
  bool goes_on_flat(size_t f, size_t g) const {
    const PlaneFit &a = fitted_.fits[f], &b = fitted_.fits[g];
    if (a.normal.cross(b.normal).norm() > kFlatTurn) return false;
    // Steps from one to the other across edges of the surface, and the noise of such a step.
    double step = 0, variance = 0;
    size_t steps = 0;
    for (uint32_t v = 0; v < graph_.size(); ++v) {
      if (fitted_.vertex_face[v] != static_cast<int32_t>(f)) continue;
      for (uint32_t n : graph_.around(v)) {
        if (fitted_.vertex_face[n] != static_cast<int32_t>(g)) continue;
        step += (reconstruction_.vertices[n] - reconstruction_.vertices[v]).dot(a.normal);
        variance += std::pow(vertex_sigma(reconstruction_, n, a), 2);
        ++steps;
      }
    }
    // Where pieces overlap, noise sorts their vertices into the higher and the lower one: 1.6 sigma apart
    // with no step at all. A mean step of up to 3 sigma is none.
    return steps >= 3 && std::abs(step) <= 3 * std::sqrt(variance * static_cast<double>(steps));
  }

  double sigma(uint32_t i, const Vec3& normal) const {
    return sigma_across(sigma_mm_[i], scan_.ray_direction(i), normal);
  }

  // Larger neighbours explain (nearly) all its points: a strip across an edge, or a crumb of a bowed face.
  bool is_false_chamfer(size_t f) const {
    size_t explained = 0;
    for (uint32_t i : members_[f]) {
      const bool by_neighbour = std::any_of(neighbours_[f].begin(), neighbours_[f].end(), [&](int32_t g) {
        const auto other = static_cast<size_t>(g);
        if (becomes_[other] != g || members_[other].size() < members_[f].size()) return false;
        const PlaneFit& plane = fitted_.fits[other];
        return plane.normal.dot(scan_.ray_direction(i)) < 0 &&
               std::abs(plane.normal.dot(scan_.points[i]) - plane.d_mm) <=
                   kGate * noise_scale(plane) * sigma(i, plane.normal);
      });
      if (by_neighbour) ++explained;
    }
    return 10 * explained >= 9 * members_[f].size();  // a tenth: points the gate lets past by chance
  }

  // A piece of a curved surface has a bow as deep as the gate, and goes on smoothly beyond its rim. A bowed
  // real face ends at edges.
  bool is_curved(size_t f) const {
    const PlaneFit& plane = fitted_.fits[f];
    Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    std::vector<Eigen::Matrix<double, 6, 1>> rows;
    double scale = 0, typical_sigma = 0;
    for (uint32_t i : members_[f]) scale = std::max(scale, (scan_.points[i] - plane.centroid_mm).norm());
    for (uint32_t i : members_[f]) {
      const Vec3 r = (scan_.points[i] - plane.centroid_mm) / scale;
      const double a = r.dot(plane.covariance.u), b = r.dot(plane.covariance.v), s = sigma(i, plane.normal);
      Eigen::Matrix<double, 6, 1> row;
      row << 1, a, b, a * a, a * b, b * b;
      information += row * row.transpose() / (s * s);
      right += row * (r.dot(plane.normal) * scale) / (s * s);
      rows.push_back(row);
      typical_sigma += s;
    }
    typical_sigma /= static_cast<double>(members_[f].size());
    const Eigen::Matrix<double, 6, 1> solution = information.ldlt().solve(right);
    const double gained = right.dot(solution);  // chi-square that the bow explains beyond the plane
    double low = 0, high = 0;
    for (const auto& row : rows) {
      const double height = row.dot(solution);
      low = std::min(low, height);
      high = std::max(high, height);
    }
    const double turn =
        2 * std::max({std::abs(solution[3]), std::abs(solution[4]), std::abs(solution[5])}) / scale;
    // Gained by chance: 3 degrees of freedom, as in kSamePlaneChi2.
    const double vertex_sigma =
        typical_sigma * std::min(1.0, reconstruction_.point_spacing_mm / reconstruction_.vertex_spacing_mm);
    if (turn <= kFlatTurn || gained <= kSamePlaneChi2) return false;
    const bool deep = high - low > kGate * vertex_sigma;
    // No plane bows by more than the angle at which two faces go on smoothly: then one of both signs will do.
    const auto goes_on = [&] {
      return soft_rim_share(reconstruction_, graph_, fitted_, f) > kGoesOnBothSides;
    };
    return turn > kSmoothSlope ? deep || goes_on() : deep && goes_on();
  }

  Regions regions_left(bool& changed) const {
    Regions regions;
    std::vector<int32_t> new_index(becomes_.size(), kNoRegion);
    for (size_t f = 0; f < becomes_.size(); ++f) {
      if (becomes_[f] != static_cast<int32_t>(f)) {
        changed = true;
        continue;
      }
      new_index[f] = static_cast<int32_t>(regions.planes.size());
      regions.planes.push_back({fitted_.fits[f].normal, fitted_.fits[f].d_mm});
    }
    regions.vertex_region = fitted_.vertex_face;
    for (int32_t& f : regions.vertex_region) {
      if (f == kNoRegion) continue;
      const int32_t g = becomes_[static_cast<size_t>(f)];
      f = g == kNoRegion ? kNoRegion : new_index[static_cast<size_t>(g)];
    }
    return regions;
  }

  const Scan& scan_;
  const Reconstruction& reconstruction_;
  const SurfaceGraph& graph_;
  const FittedFaces& fitted_;
  std::vector<double> sigma_mm_;
  std::vector<std::vector<uint32_t>> members_;
  std::vector<std::set<int32_t>> neighbours_;
  std::vector<int32_t> becomes_;  // itself, the face it is united with, or kNoRegion
};

}  // namespace

Selection select_faces(const Scan& scan, const Reconstruction& reconstruction, const SurfaceGraph& graph,
                       const FittedFaces& fitted) {
  return Selector(scan, reconstruction, graph, fitted).run();
}

double soft_rim_share(const Reconstruction& reconstruction, const SurfaceGraph& graph,
                      const FittedFaces& fitted, size_t face, int32_t but_to) {
  const double smooth_cosine = 1 / std::hypot(1, kSmoothSlope);
  const PlaneFit& plane = fitted.fits[face];
  const auto off_plane = [&](uint32_t n, const PlaneFit& p) {
    return std::abs(p.normal.dot(reconstruction.vertices[n]) - p.d_mm);
  };
  const auto on_plane = [&](uint32_t n, const PlaneFit& p) {
    return off_plane(n, p) <= kGate * vertex_sigma(reconstruction, n, p);
  };
  // A step across an edge to a vertex just below it is hardly steep: what is beyond tells by its plane, where
  // it has one.
  const auto goes_on = [&](uint32_t from, uint32_t to) {
    const int32_t other = fitted.vertex_face[to];
    if (other != kNoRegion)
      return plane.normal.dot(fitted.fits[static_cast<size_t>(other)].normal) > smooth_cosine;
    const Vec3 step = reconstruction.vertices[to] - reconstruction.vertices[from];
    return off_plane(to, plane) < kSmoothSlope * step.norm();
  };
  size_t soft = 0, hard = 0;
  for (uint32_t v = 0; v < graph.size(); ++v) {
    if (fitted.vertex_face[v] != static_cast<int32_t>(face)) continue;
    for (uint32_t n : graph.around(v)) {
      if (fitted.vertex_face[n] == static_cast<int32_t>(face)) continue;
      // What is still on the plane tells nothing.
      if (on_plane(n, plane) ||
          (but_to != kNoRegion && on_plane(n, fitted.fits[static_cast<size_t>(but_to)])))
        continue;
      ++(goes_on(v, n) ? soft : hard);
    }
  }
  return soft + hard == 0 ? 0 : static_cast<double>(soft) / static_cast<double>(soft + hard);
}

std::vector<size_t> reportable(const Scan& scan, const Reconstruction& reconstruction,
                               const FittedFaces& fitted, size_t min_points) {
  std::vector<std::vector<uint32_t>> members(fitted.fits.size());
  std::vector<size_t> on_its_side(fitted.fits.size(), 0);
  for (uint32_t i = 0; i < scan.size(); ++i) {
    if (fitted.point_face[i] != kNoRegion) members[static_cast<size_t>(fitted.point_face[i])].push_back(i);
    if (fitted.point_side[i] != kNoRegion) ++on_its_side[static_cast<size_t>(fitted.point_side[i])];
  }
  std::vector<size_t> faces;
  for (size_t f = 0; f < members.size(); ++f) {
    if (on_its_side[f] >= min_points && 2 * members[f].size() >= min_points &&
        width_mm(scan, fitted.fits[f], members[f]) >= kFaceSpacings * reconstruction.point_spacing_mm)
      faces.push_back(f);
  }
  return faces;
}

namespace {

// A face hardly wider than two spacings comes in crumbs: between them the surface goes from edge to edge and
// has no vertex on its plane. Pieces of one face a single vertex apart, one of them too small to be a face,
// are one.
void join_crumbs(const Reconstruction& reconstruction, const SurfaceGraph& graph, const FittedFaces& fitted,
                 const std::vector<int32_t>& face_of_piece, const std::vector<size_t>& points,
                 size_t face_points, std::vector<int32_t>& piece) {
  std::vector<int32_t> whole(face_of_piece.size());
  std::iota(whole.begin(), whole.end(), 0);
  const auto root = [&](int32_t p) {
    while (whole[static_cast<size_t>(p)] != p) p = whole[static_cast<size_t>(p)];
    return p;
  };
  for (uint32_t v = 0; v < graph.size(); ++v) {
    for (uint32_t n : graph.around(v)) {
      if (piece[n] == kNoRegion) continue;
      for (uint32_t m : graph.around(v)) {
        if (m <= n || piece[m] == kNoRegion) continue;
        const auto p = static_cast<size_t>(piece[n]), q = static_cast<size_t>(piece[m]);
        if (p == q || face_of_piece[p] != face_of_piece[q] || std::min(points[p], points[q]) >= face_points)
          continue;
        // Along an edge the other face turns neither towards the one crumb nor towards the other; a wall
        // between them does. Two edges of the surface reach some 3 spacings.
        const int32_t h = fitted.vertex_face[v];
        const Vec3 step = reconstruction.vertices[m] - reconstruction.vertices[n];
        const double across =
            h == kNoRegion ? step.norm() : std::abs(fitted.fits[static_cast<size_t>(h)].normal.dot(step));
        if (across > reconstruction.vertex_spacing_mm || step.norm() > 3 * reconstruction.vertex_spacing_mm)
          continue;
        const auto [low, high] = std::minmax({root(piece[n]), root(piece[m])});
        whole[static_cast<size_t>(high)] = low;
      }
    }
  }
  for (int32_t& p : piece) {
    if (p != kNoRegion) p = root(p);
  }
}

}  // namespace

FittedFaces split_unconnected(const Scan& scan, const Reconstruction& reconstruction,
                              const SurfaceGraph& graph, FittedFaces fitted, size_t min_points,
                              size_t face_points) {
  // Connected is what vertices on the plane connect, whichever face they were given to: those at an edge lie
  // on both, and a narrow face has hardly others.
  const auto on_plane = [&](uint32_t v, const PlaneFit& plane) {
    const double sigma =
        sigma_across(reconstruction.vertex_sigma_mm[v], reconstruction.vertex_ray[v], plane.normal);
    return plane.normal.dot(reconstruction.vertex_ray[v]) < 0 &&
           std::abs(plane.normal.dot(reconstruction.vertices[v]) - plane.d_mm) <=
               kGate * noise_scale(plane) * sigma;
  };
  std::vector<int32_t> piece(graph.size(), kNoRegion), visited(graph.size(), kNoRegion), face_of_piece;
  for (uint32_t seed = 0; seed < graph.size(); ++seed) {
    const int32_t face = fitted.vertex_face[seed];
    if (face == kNoRegion || piece[seed] != kNoRegion) continue;
    const auto id = static_cast<int32_t>(face_of_piece.size());
    face_of_piece.push_back(face);
    std::vector<uint32_t> queue{seed};
    piece[seed] = visited[seed] = id;
    for (size_t at = 0; at < queue.size(); ++at) {
      for (uint32_t n : graph.around(queue[at])) {
        if (visited[n] == id) continue;
        const bool own = fitted.vertex_face[n] == face;
        if (!own && !on_plane(n, fitted.fits[static_cast<size_t>(face)])) continue;
        visited[n] = id;
        if (own) piece[n] = id;
        queue.push_back(n);
      }
    }
  }
  std::vector<size_t> points_of_piece(face_of_piece.size(), 0);
  for (uint32_t i = 0; i < scan.size(); ++i) {
    const uint32_t v = reconstruction.point_vertex[i];
    if (piece[v] != kNoRegion && fitted.point_side[i] == fitted.vertex_face[v])
      ++points_of_piece[static_cast<size_t>(piece[v])];
  }
  join_crumbs(reconstruction, graph, fitted, face_of_piece, points_of_piece, face_points, piece);
  std::vector<std::vector<uint32_t>> members(face_of_piece.size());
  std::vector<size_t> on_its_side(face_of_piece.size(), 0);
  for (uint32_t i = 0; i < scan.size(); ++i) {
    const uint32_t v = reconstruction.point_vertex[i];
    if (piece[v] == kNoRegion) continue;
    if (fitted.point_face[i] == fitted.vertex_face[v]) members[static_cast<size_t>(piece[v])].push_back(i);
    if (fitted.point_side[i] == fitted.vertex_face[v]) ++on_its_side[static_cast<size_t>(piece[v])];
  }

  const std::vector<double> sigma_mm = floored_sigma_mm(scan);
  FittedFaces result;
  result.point_face.assign(scan.size(), kNoRegion);
  std::vector<int32_t> new_index(face_of_piece.size(), kNoRegion);
  for (size_t p = 0; p < members.size(); ++p) {
    if (on_its_side[p] < min_points || 2 * members[p].size() < min_points) continue;
    const Vec3 normal = fitted.fits[static_cast<size_t>(face_of_piece[p])].normal;
    const auto plane = fit_members(scan, sigma_mm, members[p], normal);
    if (!plane) continue;
    new_index[p] = static_cast<int32_t>(result.fits.size());
    for (uint32_t i : members[p]) result.point_face[i] = new_index[p];
    result.fits.push_back(*plane);
  }
  result.point_side.assign(scan.size(), kNoRegion);
  for (uint32_t i = 0; i < scan.size(); ++i) {
    const uint32_t v = reconstruction.point_vertex[i];
    if (piece[v] != kNoRegion && fitted.point_side[i] == fitted.vertex_face[v])
      result.point_side[i] = new_index[static_cast<size_t>(piece[v])];
  }
  result.vertex_face.assign(graph.size(), kNoRegion);
  for (uint32_t v = 0; v < graph.size(); ++v) {
    if (piece[v] != kNoRegion) result.vertex_face[v] = new_index[static_cast<size_t>(piece[v])];
  }
  return result;
}

}  // namespace tetragauge
