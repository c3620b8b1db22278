// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/inspect/measure_face.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/geometry/fit_plane_along_rays.hpp"
#include "host/inspect/form.hpp"
#include "host/inspect/point_grid.hpp"
#include "host/solid/surface_crossings.hpp"

namespace tetragauge {
namespace {

// Where each point belongs on its surface, so that a face out of place has its edge where its points are.
class Feet {
 public:
  explicit Feet(const FaceMeasurement& in) : in_(in) {
    if (in.face.type == SurfaceType::plane) plane_ = fit_along_rays(in);
  }

  // On a plane along its own ray: a point's error is no move over the face. On a curved face the nearest
  // place of the surface, or without its closed form where the ray meets it.
  Vec3 of(uint32_t i) const {
    const Vec3& p = in_.cast.points_mm[i];
    if (!plane_) {
      if (!has_crossings(in_.face)) return in_.cast.hit_mm[i];
      return p - distance_to_surface(in_.face, p) * surface_normal(in_.face, p);
    }
    const Vec3 at = meet_plane(p, in_.cast.direction[i], plane_->normal, plane_->centroid_mm);
    return at - in_.face.normal * (in_.face.normal.dot(at) - in_.face.d_mm);
  }

 private:
  const FaceMeasurement& in_;
  std::optional<PlaneFit> plane_;
};

std::vector<uint32_t> enough(std::vector<uint32_t> kept, const std::vector<uint32_t>& all) {
  return kept.size() >= kLeastPoints ? kept : all;
}

// Three sigma or a quarter of a spacing: as close to an edge as what lies beyond it can be told apart.
double margin_mm(const FaceMeasurement& in, double spacing_mm) {
  std::vector<double> sigma;
  for (const uint32_t i : in.points) sigma.push_back(in.cast.sigma_mm[i]);
  std::nth_element(sigma.begin(), sigma.begin() + static_cast<std::ptrdiff_t>(sigma.size() / 2), sigma.end());
  return std::max(3 * sigma[sigma.size() / 2], 0.25 * spacing_mm);
}

// Points within the margin of the face's edge hold light from both sides of it.
std::vector<uint32_t> away_from_edges(const FaceMeasurement& in, const Feet& feet, double margin) {
  const std::vector<Vec3> edge = samples_along(in.outline, 0.5 * margin);
  const PointGrid grid(edge, margin);
  std::vector<uint32_t> kept;
  for (const uint32_t i : in.points)
    if (!grid.any_within(feet.of(i), margin)) kept.push_back(i);
  return enough(std::move(kept), in.points);
}

// Whether the whole beam falls on the face, and no part of it on an edge that it passes on its way, or beyond
// one.
bool falls_whole(const FaceMeasurement& in, uint32_t i) {
  constexpr int kAround = 6;
  constexpr double kLongest = 5;  // the spot, in radii: it falls at 78 degrees then, or over a step
  const auto [u, v] = tangent_frame(in.cast.direction[i]);
  for (int k = 0; k < kAround; ++k) {
    const double angle = 2 * std::numbers::pi * k / kAround;
    const Vec3 beside = in.spot_mm * (std::cos(angle) * u + std::sin(angle) * v);
    const auto hit = in.caster.first_hit(in.cast.origin_mm[i] + beside, in.cast.direction[i]);
    if (!hit || hit->face != in.cast.face[i] ||
        (hit->point_mm - in.cast.hit_mm[i]).norm() > kLongest * in.spot_mm)
      return false;
  }
  return true;
}

std::vector<uint32_t> whole_spots(const FaceMeasurement& in) {
  if (!(in.spot_mm > 0)) return in.points;
  std::vector<char> is_whole(in.points.size(), 0);
  tbb::parallel_for(size_t{0}, in.points.size(),
                    [&](size_t k) { is_whole[k] = falls_whole(in, in.points[k]); });
  std::vector<uint32_t> kept;
  for (size_t k = 0; k < in.points.size(); ++k)
    if (is_whole[k]) kept.push_back(in.points[k]);
  return kept;
}

// Where light grazes a curved face, the face turns away under the spot: a camera that sees a part of it best
// takes that for its middle. The planner keeps below this incidence, too. (A plane does not turn.)
std::vector<uint32_t> well_lit(const FaceMeasurement& in) {
  const double least_cosine = std::cos(65 * std::numbers::pi / 180);
  std::vector<uint32_t> kept;
  for (const uint32_t i : in.points)
    if (in.cast.cosine[i] >= least_cosine) kept.push_back(i);
  return enough(std::move(kept), in.points);
}

void compare_points(const FaceMeasurement& in, FaceInspection& out) {
  std::vector<double> sizes;
  double sum = 0, squares = 0;
  for (const uint32_t i : in.points) {
    const double deviation = in.cast.deviation_mm[i];
    sum += deviation;
    squares += deviation * deviation;
    sizes.push_back(std::abs(deviation));
  }
  const double count = static_cast<double>(sizes.size());
  out.point_mean_mm = sum / count;
  out.point_rms_mm = std::sqrt(squares / count);
  std::sort(sizes.begin(), sizes.end());
  out.point_p95_mm = sizes[(sizes.size() - 1) * 19 / 20];
  out.point_max_mm = sizes.back();
}

}  // namespace

double inflation(double chi2, double freedom) {
  return freedom > 0 ? std::max(1.0, chi2 / freedom) : 1.0;
}

double coverage(const FaceMeasurement& in, double spacing_mm) {
  if (in.points.empty() || !(spacing_mm > 0)) return 0;
  const Feet feet(in);
  std::vector<Vec3> points;
  for (const uint32_t i : in.points) points.push_back(feet.of(i));
  const double near = 1.5 * spacing_mm;
  const PointGrid grid(points, near);
  const std::vector<Vec3> samples = samples_over(in.outline, 1000);
  const auto covered =
      std::count_if(samples.begin(), samples.end(), [&](const Vec3& p) { return grid.any_within(p, near); });
  return samples.empty() ? 0 : static_cast<double>(covered) / static_cast<double>(samples.size());
}

void measure_residuals(const FaceMeasurement& in, std::span<const Vec3> place,
                       std::span<const double> residual, double area_mm2, FaceInspection& out) {
  double squares = 0, sigma_squares = 0, sigma = 0, low = 1e300, high = -1e300;
  for (size_t k = 0; k < residual.size(); ++k) {
    const double of_point = in.cast.sigma_mm[in.points[k]];
    squares += residual[k] * residual[k];
    sigma_squares += of_point * of_point;
    sigma += of_point;
    low = std::min(low, residual[k]);
    high = std::max(high, residual[k]);
  }
  const double count = static_cast<double>(residual.size());
  out.rms_mm = std::sqrt(squares / count);
  out.machine_sigma_mm = std::sqrt(sigma_squares / count);
  out.peak_to_valley_mm = high - low;
  // What form is looked for against where the tolerance says nothing: five sigma.
  const double wanted = in.tolerance_mm > 0 ? in.tolerance_mm : std::max(1e-9, 5 * sigma / count);
  const Form form = form_deviation(place, residual, area_mm2, wanted);
  out.form_mm = form.form_mm;
  out.U_form_mm = form.U_mm;
}

void measure_face(const FaceMeasurement& in, FaceInspection& out) {
  const double area =
      in.measured_area_mm2 > 0 ? std::min(in.measured_area_mm2, in.face.area_mm2) : in.face.area_mm2;
  const double spacing = std::sqrt(area / static_cast<double>(in.points.size()));
  out.coverage = coverage(in, spacing);
  out.measured_area_mm2 = in.measured_area_mm2 > 0 ? area : out.coverage * in.face.area_mm2;
  FaceMeasurement inner = in;
  inner.points = whole_spots(in);
  if (inner.points.size() < kLeastPoints) {
    out.reason = "too narrow for the beam: it falls whole on the face in " +
                 std::to_string(inner.points.size()) + " of " + std::to_string(in.points.size()) + " points";
    return;
  }
  if (const double margin = margin_mm(inner, spacing); margin > 0)
    inner.points = away_from_edges(inner, Feet(inner), margin);
  out.points_used = inner.points.size();
  out.points_rejected += in.points.size() - inner.points.size();
  compare_points(inner, out);
  if (in.face.type == SurfaceType::plane) {
    measure_plane(inner, out);
  } else {
    inner.points = well_lit(inner);
    measure_curve(inner, out);
  }
}

}  // namespace tetragauge
