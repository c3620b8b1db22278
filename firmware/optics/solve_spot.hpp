// SPDX-License-Identifier: Apache-2.0
// The spot's coordinate from the beam and one or two camera rays: the point of least squares, each ray
// weighted by its uncertainty at the spot.
//
//   Spot<float> spot = solve_spot(geometry, beam, {view_1, view_2});
//
// Rows n . p = n . o with standard deviation s: two across the beam (s = range * direction_sigma), two for
// each camera (psd_camera.hpp: s = t * sigma of the detector position, through the slope of the distortion).
// Covariance C = (sum n n' / s^2)^-1; sigma along the beam d is sqrt(d' C d). Solved about a first guess, so
// that float keeps its digits.
#pragma once

#include "firmware/optics/galvo.hpp"
#include "firmware/optics/psd_camera.hpp"

namespace tetragauge {

template <class Scalar>
struct CameraView {
  bool used = false;
  DetectorPosition<Scalar> position;
  Scalar sigma_x_mm{}, sigma_y_mm{};  // of the position
};

template <class Scalar>
struct Spot {
  bool solved = false;
  Vector3<Scalar> point;  // machine frame
  Scalar sigma_mm{};      // along the beam
  Scalar gap_mm{};        // largest distance from the point to one of the rays
  Scalar gap_sigma_mm{};  // that ray's standard deviation across, there
};

namespace detail {
// Normal equations of a 3-D point, symmetric.
template <class Scalar>
struct PointEquations {
  Scalar xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
  Vector3<Scalar> rhs;

  void add(const Vector3<Scalar>& n, Scalar value, Scalar sigma) {
    const Scalar w = Scalar(1) / (sigma * sigma);
    xx = xx + w * n.x * n.x;
    xy = xy + w * n.x * n.y;
    xz = xz + w * n.x * n.z;
    yy = yy + w * n.y * n.y;
    yz = yz + w * n.y * n.z;
    zz = zz + w * n.z * n.z;
    rhs = rhs + n * (w * value);
  }
  // M^-1 v by cofactors; the caller checks the determinant.
  Scalar determinant() const {
    return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  }
  Vector3<Scalar> solve(const Vector3<Scalar>& v, Scalar det) const {
    const Scalar ixx = yy * zz - yz * yz, ixy = xz * yz - xy * zz, ixz = xy * yz - xz * yy;
    const Scalar iyy = xx * zz - xz * xz, iyz = xy * xz - xx * yz, izz = xx * yy - xy * xy;
    return Vector3<Scalar>{ixx * v.x + ixy * v.y + ixz * v.z, ixy * v.x + iyy * v.y + iyz * v.z,
                           ixz * v.x + iyz * v.y + izz * v.z} *
           (Scalar(1) / det);
  }
};

// Two unit vectors across a unit direction.
template <class Scalar>
void across(const Vector3<Scalar>& d, Vector3<Scalar>* u, Vector3<Scalar>* v) {
  const bool steep = d.z > Scalar(0.9) || d.z < Scalar(-0.9);
  *u = normalized(cross(d, steep ? Vector3<Scalar>{1, 0, 0} : Vector3<Scalar>{0, 0, 1}));
  *v = cross(d, *u);
}
}  // namespace detail

template <class Scalar>
Spot<Scalar> solve_spot(const MachineGeometry<Scalar>& machine, const Beam<Scalar>& beam,
                        const CameraView<Scalar> (&views)[2]) {
  Spot<Scalar> spot;
  CameraRay<Scalar> rays[2];
  Scalar range{};
  Scalar best{};
  // First guess: the beam cut by the camera plane it meets most steeply.
  for (int i = 0; i < 2; ++i) {
    if (!views[i].used) continue;
    rays[i] = ray_from_detector(machine.camera[i], views[i].position);
    const Vector3<Scalar> normals[2] = {rays[i].n_x, rays[i].n_y};
    for (const Vector3<Scalar>& n : normals) {
      const Scalar slope = dot(n, beam.direction);
      const Scalar steepness = slope * slope / dot(n, n);
      if (steepness > best) {
        best = steepness;
        range = dot(n, rays[i].origin - beam.origin) / slope;
      }
    }
  }
  if (!(best > Scalar(1e-4)) || !(range > 0)) return spot;

  // Of the ideal positions.
  Scalar sigma_x[2]{}, sigma_y[2]{};
  for (int i = 0; i < 2; ++i) {
    if (!views[i].used) continue;
    const auto through = [&](Scalar by_x, Scalar by_y) {
      const Scalar x = by_x * views[i].sigma_x_mm, y = by_y * views[i].sigma_y_mm;
      return square_root(x * x + y * y);
    };
    sigma_x[i] = through(rays[i].x_by_x, rays[i].x_by_y);
    sigma_y[i] = through(rays[i].y_by_x, rays[i].y_by_y);
  }
  Vector3<Scalar> u, v;
  detail::across(beam.direction, &u, &v);
  spot.point = beam.origin + beam.direction * range;
  // Twice: the second time with the standard deviations at the place found.
  for (int pass = 0; pass < 2; ++pass) {
    detail::PointEquations<Scalar> equations;
    const Scalar beam_sigma =
        dot(spot.point - beam.origin, beam.direction) * machine.galvo.direction_sigma_rad;
    const Vector3<Scalar> from_beam = beam.origin - spot.point;
    equations.add(u, dot(u, from_beam), beam_sigma);
    equations.add(v, dot(v, from_beam), beam_sigma);
    spot.gap_mm = 0;
    for (int i = 0; i < 2; ++i) {
      if (!views[i].used) continue;
      const CameraRay<Scalar>& ray = rays[i];
      const Vector3<Scalar> from_camera = ray.origin - spot.point;
      const Scalar t = -dot(from_camera, ray.direction) / dot(ray.direction, ray.direction);
      equations.add(ray.n_x, dot(ray.n_x, from_camera), t * sigma_x[i]);
      equations.add(ray.n_y, dot(ray.n_y, from_camera), t * sigma_y[i]);
    }
    const Scalar det = equations.determinant();
    if (!(det > 0)) return spot;
    spot.point = spot.point + equations.solve(equations.rhs, det);
    spot.sigma_mm = square_root(dot(beam.direction, equations.solve(beam.direction, det)));
  }

  // The gap, ray by ray, at the point found.
  const auto consider = [&](const Vector3<Scalar>& to, const Vector3<Scalar>& direction, Scalar sigma) {
    const Scalar gap = length(cross(to, direction));
    if (gap >= spot.gap_mm) {
      spot.gap_mm = gap;
      spot.gap_sigma_mm = sigma;
    }
  };
  const Vector3<Scalar> to = spot.point - beam.origin;
  consider(to, beam.direction, length(to) * machine.galvo.direction_sigma_rad);
  for (int i = 0; i < 2; ++i) {
    if (!views[i].used) continue;
    const Vector3<Scalar> d = rays[i].direction;
    const Scalar inverse_length = Scalar(1) / length(d);
    const Scalar sigma = sigma_x[i] > sigma_y[i] ? sigma_x[i] : sigma_y[i];
    const Vector3<Scalar> from_camera = spot.point - rays[i].origin;
    consider(from_camera, d * inverse_length, length(from_camera) * inverse_length * sigma);
  }
  // A NaN, from whatever input, is no solution.
  spot.solved = spot.sigma_mm > 0 && spot.gap_mm >= 0;
  return spot;
}

}  // namespace tetragauge
