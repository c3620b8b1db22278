// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/spot.hpp"

#include <cmath>
#include <numbers>

namespace tetragauge::sim {
namespace {

using std::numbers::pi;

constexpr int kRing = 6;

// 1/e^2 radius of a Gaussian beam at a distance from its waist (Siegman, Lasers, eq. 17.5).
double beam_radius_mm(const Numbers& n, double from_waist_mm) {
  const double rayleigh_mm = pi * n.waist_mm * n.waist_mm / n.wavelength_mm;
  return n.waist_mm * std::hypot(1.0, from_waist_mm / rayleigh_mm);
}

struct CameraSum {
  double current_A = 0, x = 0, y = 0, magnification = 0;
};

// Light of one sub-ray's patch into one camera: Lambert's law, dP = albedo P / pi cos(out) dOmega, with the
// lens' opening seen from the patch (its area times the cosine to its axis, over the distance squared).
void add_patch(const Numbers& n, const TrueCamera& camera, const PartOnTable& part,
               const RigidTransform& T_part_machine, const Vec3& lens_part,
               const RigidTransform& T_machine_part, const SurfaceHit& hit, double power_W, CameraSum& sum) {
  const Vec3 to_lens = lens_part - hit.point_mm;
  const double distance = to_lens.norm();
  const double cos_out = hit.normal.dot(to_lens) / distance;
  if (cos_out <= 0) return;
  const Vec3 point_machine = T_machine_part * hit.point_mm;
  const auto spot = image_on_detector(camera, point_machine);
  if (!spot || std::abs(spot->x) > 1 || std::abs(spot->y) > 1) return;  // beside the detector
  if (!part.sees(hit.point_mm, lens_part)) return;
  const Vec3 looks = T_part_machine.R * camera.T_camera_machine.R.row(2).transpose();
  const double cos_lens = -looks.dot(to_lens) / distance;
  const double solid_angle =
      pi * n.aperture_radius_mm * n.aperture_radius_mm * cos_lens / (distance * distance);
  const double current =
      hit.albedo * power_W / pi * cos_out * solid_angle * n.lens_transmission * n.responsivity_A_W;
  sum.current_A += current;
  sum.x += current * spot->x;
  sum.y += current * spot->y;
  sum.magnification += current * camera.focal_mm / (distance * cos_lens);
}

}  // namespace

SpotImages image_spot(const Numbers& n, const TrueGeometry& geometry, const PartOnTable& part,
                      const RigidTransform& T_machine_part, const Line& beam) {
  const RigidTransform T_part_machine = T_machine_part.inverse();
  const Vec3 origin = T_part_machine * beam.point, direction = T_part_machine.R * beam.direction;
  const std::array<Vec3, 2> lens{
      T_part_machine * geometry.cameras[0].T_camera_machine.inverse().t,
      T_part_machine * geometry.cameras[1].T_camera_machine.inverse().t,
  };
  std::array<CameraSum, 2> sums;
  const auto add = [&](const SurfaceHit& hit, double weight) {
    for (size_t c = 0; c < 2; ++c) {
      add_patch(n, geometry.cameras[c], part, T_part_machine, lens[c], T_machine_part, hit,
                weight * n.laser_W, sums[c]);
    }
  };
  // Stroud's 7-point rule of degree 5 for a Gaussian weight in the plane (Approximate Calculation of Multiple
  // Integrals, E2^r2: 5-1): half the power in the middle, the rest in 6 points at the 1/e^2 radius.
  const auto middle = part.first_hit(origin, direction);
  if (middle) add(*middle, 0.5);
  const double reached = middle ? middle->distance_mm : n.focus_distance_mm;
  const double radius = beam_radius_mm(n, reached - n.focus_distance_mm);
  const auto [u, v] = tangent_frame(direction);
  for (int k = 0; k < kRing; ++k) {
    const double angle = 2 * pi * k / kRing;
    const Vec3 offset = radius * (std::cos(angle) * u + std::sin(angle) * v);
    if (const auto hit = part.first_hit(origin + offset, direction)) add(*hit, 0.5 / kRing);
  }
  SpotImages images;
  for (size_t c = 0; c < 2; ++c) {
    const CameraSum& s = sums[c];
    if (s.current_A > 0) {
      images[c] = {s.current_A, s.x / s.current_A, s.y / s.current_A, s.magnification / s.current_A};
    }
  }
  return images;
}

}  // namespace tetragauge::sim
