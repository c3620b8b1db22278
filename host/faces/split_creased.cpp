// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/faces/split_creased.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "host/faces/compare_planes.hpp"
#include "host/reconstruct/average_points.hpp"

namespace tetragauge {
namespace {

// Height over the fitted plane against position in it, with weights 1 / sigma^2 across.
struct Sample {
  double a, b, height, weight;
};

struct Bow {
  Eigen::Vector2d across;  // unit, in (u, v): the direction in which the surface bends most
  double chi2 = 0;         // left over by a quadratic surface
};

Bow fit_bow(const std::vector<Sample>& samples, double scale) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6 right = Vector6::Zero();
  double chi2 = 0;
  for (const Sample& s : samples) {
    const double a = s.a / scale, b = s.b / scale;
    Vector6 row;
    row << 1, a, b, a * a, a * b, b * b;
    information += s.weight * row * row.transpose();
    right += s.weight * s.height * row;
    chi2 += s.weight * s.height * s.height;
  }
  const Vector6 solution = information.ldlt().solve(right);
  Eigen::Matrix2d curvature;
  curvature << 2 * solution[3], solution[4], solution[4], 2 * solution[5];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(curvature);
  const int most = std::abs(eigen.eigenvalues()[0]) > std::abs(eigen.eigenvalues()[1]) ? 0 : 1;
  return {eigen.eigenvectors().col(most), chi2 - right.dot(solution)};
}

// Chi-square of the best plane through some samples, by sums that can be added and subtracted.
struct PlaneSums {
  Mat3 information = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  double squares = 0;
  size_t count = 0;

  void add(const Sample& s, double sign = 1) {
    const Vec3 row(1, s.a, s.b);
    information += sign * s.weight * row * row.transpose();
    right += sign * s.weight * s.height * row;
    squares += sign * s.weight * s.height * s.height;
    count += sign > 0 ? 1 : static_cast<size_t>(-1);
  }
  Vec3 solution() const { return information.ldlt().solve(right); }
  double chi2() const { return squares - right.dot(solution()); }
};

struct Crease {
  Eigen::Vector2d across;
  double position = 0;  // across . (a, b)
  double chi2 = 0;      // left over by the two planes
  double turn = 0;      // angle between them, rad
};

// Over all positions that leave at least a tenth of the points on either side.
std::optional<Crease> best_crease(std::vector<Sample> samples, const Eigen::Vector2d& across) {
  const auto position = [&](const Sample& s) { return across.x() * s.a + across.y() * s.b; };
  std::sort(samples.begin(), samples.end(),
            [&](const Sample& p, const Sample& q) { return position(p) < position(q); });
  PlaneSums below, above;
  for (const Sample& s : samples) above.add(s);
  const size_t margin = std::max<size_t>(samples.size() / 10, 6);
  const size_t stride = std::max<size_t>(samples.size() / 100, 1);
  std::optional<Crease> best;
  for (size_t i = 0; i + margin < samples.size(); ++i) {
    below.add(samples[i]);
    above.add(samples[i], -1);
    if (i + 1 < margin || i % stride != 0) continue;
    const double chi2 = below.chi2() + above.chi2();
    if (best && chi2 >= best->chi2) continue;
    const Vec3 difference = below.solution() - above.solution();
    best = Crease{across, position(samples[i]), chi2, std::hypot(difference[1], difference[2])};
  }
  return best;
}

// A face as two planes.
struct Parting {
  Crease crease;
  std::array<Plane, 2> part;  // below the crease and above it
};

std::optional<Parting> part_face(const Scan& scan, const std::vector<double>& sigma_mm, const PlaneFit& plane,
                                 const std::vector<uint32_t>& members) {
  const Vec3 &u = plane.covariance.u, &v = plane.covariance.v;
  std::vector<Sample> samples;
  samples.reserve(members.size());
  double scale = 0, chi2 = 0;
  for (uint32_t i : members) {
    const Vec3 r = scan.points[i] - plane.centroid_mm;
    const double s = sigma_across(sigma_mm[i], scan.ray_direction(i), plane.normal);
    samples.push_back({r.dot(u), r.dot(v), r.dot(plane.normal), 1 / (s * s)});
    scale = std::max(scale, r.norm());
    chi2 += samples.back().weight * samples.back().height * samples.back().height;
  }
  if (samples.size() < 24 || !(scale > 0)) return std::nullopt;
  const Bow bow = fit_bow(samples, scale);
  if (chi2 - bow.chi2 <= kSamePlaneChi2) return std::nullopt;  // as flat as its noise allows
  const auto crease = best_crease(samples, bow.across);
  if (!crease || crease->turn < kFlatTurn || crease->chi2 > bow.chi2 ||
      chi2 - crease->chi2 <= 2 * kSamePlaneChi2)
    return std::nullopt;
  PlaneSums side[2];
  for (const Sample& s : samples)
    side[crease->across.x() * s.a + crease->across.y() * s.b > crease->position ? 1 : 0].add(s);
  Parting parting{*crease, {}};
  for (size_t k = 0; k < 2; ++k) {
    const Vec3 h = side[k].solution();  // height = h0 + h1 a + h2 b
    const Vec3 normal = (plane.normal - h[1] * u - h[2] * v).normalized();
    parting.part[k] = {normal, normal.dot(plane.centroid_mm + h[0] * plane.normal)};
  }
  return parting;
}

}  // namespace

Creased split_creased(const Scan& scan, const Reconstruction& reconstruction, const FittedFaces& fitted,
                      const std::vector<size_t>& faces) {
  Creased creased;
  Regions& regions = creased.regions;
  regions.vertex_region = fitted.vertex_face;
  std::vector<std::vector<uint32_t>> members(fitted.fits.size());
  for (uint32_t i = 0; i < scan.size(); ++i) {
    if (fitted.point_face[i] != kNoRegion) members[static_cast<size_t>(fitted.point_face[i])].push_back(i);
  }
  for (const PlaneFit& fit : fitted.fits) regions.planes.push_back({fit.normal, fit.d_mm});

  const std::vector<double> sigma_mm = floored_sigma_mm(scan);
  std::vector<std::optional<Parting>> partings(faces.size());
  tbb::parallel_for(size_t{0}, faces.size(), [&](size_t k) {
    partings[k] = part_face(scan, sigma_mm, fitted.fits[faces[k]], members[faces[k]]);
  });
  for (size_t k = 0; k < faces.size(); ++k) {
    if (!partings[k]) continue;
    const size_t f = faces[k];
    const PlaneFit& plane = fitted.fits[f];
    const auto& [crease, part] = *partings[k];
    const auto second = static_cast<int32_t>(regions.planes.size());
    creased.parted.push_back(f);
    regions.planes[f] = part[0];
    regions.planes.push_back(part[1]);
    for (size_t w = 0; w < regions.vertex_region.size(); ++w) {
      if (fitted.vertex_face[w] != static_cast<int32_t>(f)) continue;
      const Vec3 r = reconstruction.vertices[w] - plane.centroid_mm;
      if (crease.across.x() * r.dot(plane.covariance.u) + crease.across.y() * r.dot(plane.covariance.v) >
          crease.position)
        regions.vertex_region[w] = second;
    }
  }
  return creased;
}

}  // namespace tetragauge
