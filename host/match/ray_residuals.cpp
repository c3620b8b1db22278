// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/ray_residuals.hpp"

#include <algorithm>
#include <cmath>

#include "host/solid/surface_crossings.hpp"

namespace tetragauge {
namespace {

constexpr double kLeastCosine = 0.1;  // beyond 84 degrees of incidence a range says little about the surface

// A point against a face: the analytic surface where there is one, else the tangent plane.
RayResidual against_face(const SurfaceProblem& problem, int index, const Vec3& p, const Vec3& at,
                         const Vec3& normal) {
  RayResidual out;
  out.near = true;
  out.face = index;
  const Face& face = problem.faces[static_cast<size_t>(index)];
  if (has_crossings(face)) {
    out.offset_mm = distance_to_surface(face, p);
    out.normal = surface_normal(face, p);
    out.foot_mm = p - out.offset_mm * out.normal;
  } else {
    out.offset_mm = normal.dot(p - at);
    out.normal = normal;
    // As the ray moves, so does the place where it meets the surface: what counts is the motion there.
    out.foot_mm = at;
  }
  return out;
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<RayResidual> ray_residuals(const SurfaceProblem& problem, const RigidTransform& T,
                                       size_t points) {
  std::vector<RayResidual> residuals(std::min(points, problem.points.size()));
  const double reach_mm = 2 * problem.size_mm;  // the ray is followed from so far before the point
  for (size_t i = 0; i < residuals.size(); ++i) {
    RayResidual& out = residuals[i];
    const Vec3 p = T * problem.points[i].point_mm, towards = T.R * problem.points[i].towards;
    double distance = problem.size_mm;  // for choosing between the two: how far the point is off at all
    if (const SurfaceSample* sample = problem.model.find(p, towards)) {
      const Vec3 error = p - sample->point_mm;
      const double across = sample->normal.dot(error);
      const double along = (error - across * sample->normal).norm();
      if (along < 1.5 * problem.model_spacing_mm) {
        out = against_face(problem, sample->face, p, p - across * sample->normal, sample->normal);
        distance = std::abs(across);
      }
    }
    const double before = std::min(reach_mm, problem.points[i].range_mm);
    const std::optional<RayHit> hit = problem.caster.first_hit(p + before * towards, -towards);
    if (hit) {
      const double across = hit->normal.dot(p - hit->point_mm);
      // The hit is exact where the sample is not; it is left only where the ray meets something else.
      if (std::abs(across) < distance + 0.25 * problem.model_spacing_mm &&
          std::abs(hit->distance_mm - before) < 3 * problem.model_spacing_mm + 4 * std::abs(across))
        out = against_face(problem, hit->face, p, hit->point_mm, hit->normal);
      else if (hit->distance_mm < before)
        out.behind_mm = std::max(0.0, -across);
    }
    if (!out.near) continue;
    const double cosine = std::max(kLeastCosine, std::abs(out.normal.dot(towards)));
    out.variance_mm2 = std::pow(problem.points[i].sigma_mm * cosine, 2);
  }
  return residuals;
}

double scatter_about_surface(const SurfaceProblem& problem, const std::vector<RayResidual>& residuals) {
  std::vector<double> offsets;
  for (const RayResidual& r : residuals) offsets.push_back(r.near ? std::abs(r.offset_mm) : problem.size_mm);
  return kFromMedian * median(std::move(offsets));
}

}  // namespace tetragauge
