// SPDX-License-Identifier: Apache-2.0
// A PSD camera: from detector position to a ray, and from a point to the detector.
//
// Camera frame: x, y along the detector, z = x cross y out into the scene, origin at the centre of
// projection. A spot at (X, Y, Z) has, for an untilted detector, the ideal position x = f X / Z, y = f Y / Z:
// the lens turns the image round, the wiring turns it back. The measured position differs from the ideal one
// by electrical centre and distortion.
#pragma once

#include "firmware/optics/geometry.hpp"
#include "firmware/optics/rotate.hpp"

namespace tetragauge {

template <class Scalar>
struct DetectorPosition {
  Scalar x_mm{}, y_mm{};
};

// The set of points p with project(p) = position: p = centre + t direction. n_x is the gradient of the ideal
// projection's x times t: a displacement d of the spot at t moves x by n_x . d / t; n_y alike.
template <class Scalar>
struct CameraRay {
  Vector3<Scalar> origin, direction;  // direction has length about f
  Vector3<Scalar> n_x, n_y;
  Scalar x_by_x{}, x_by_y{}, y_by_x{}, y_by_y{};  // slope of the ideal position over the measured one
};

namespace detail {
template <class Scalar>
struct DetectorAxes {
  Vector3<Scalar> x, y, z;  // machine frame; z the camera's axis, not the detector's normal
};

// The detector turned by Rx(tilt_x) Ry(tilt_y).
template <class Scalar>
DetectorAxes<Scalar> detector_axes(const CameraGeometry<Scalar>& camera) {
  const Vector3<Scalar> z = cross(camera.x_axis, camera.y_axis);
  const SinCos<Scalar> tx = sin_cos(camera.tilt_x_rad), ty = sin_cos(camera.tilt_y_rad);
  const Vector3<Scalar> x =
      camera.x_axis * ty.cos + camera.y_axis * (tx.sin * ty.sin) - z * (tx.cos * ty.sin);
  const Vector3<Scalar> y = camera.y_axis * tx.cos + z * tx.sin;
  return {x, y, z};
}

// What is added to the measured position to make it ideal, besides the centre.
template <class Scalar>
DetectorPosition<Scalar> distortion(const CameraGeometry<Scalar>& camera,
                                    const DetectorPosition<Scalar>& at) {
  const Scalar u = at.x_mm / camera.half_size_mm, v = at.y_mm / camera.half_size_mm;
  const Scalar terms[kDistortionTerms] = {u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v};
  DetectorPosition<Scalar> sum;
  for (int i = 0; i < kDistortionTerms; ++i) {
    sum.x_mm = sum.x_mm + camera.distortion_x[i] * terms[i];
    sum.y_mm = sum.y_mm + camera.distortion_y[i] * terms[i];
  }
  return sum;
}

// Its derivatives, and the measured position's own.
template <class Scalar>
void distortion_slope(const CameraGeometry<Scalar>& camera, const DetectorPosition<Scalar>& at,
                      CameraRay<Scalar>* ray) {
  const Scalar h = camera.half_size_mm, u = at.x_mm / h, v = at.y_mm / h;
  const Scalar by_u[kDistortionTerms] = {2 * u, v, 0, 3 * u * u, 2 * u * v, v * v, 0};
  const Scalar by_v[kDistortionTerms] = {0, u, 2 * v, 0, u * u, 2 * u * v, 3 * v * v};
  Scalar xu{}, xv{}, yu{}, yv{};
  for (int i = 0; i < kDistortionTerms; ++i) {
    xu = xu + camera.distortion_x[i] * by_u[i];
    xv = xv + camera.distortion_x[i] * by_v[i];
    yu = yu + camera.distortion_y[i] * by_u[i];
    yv = yv + camera.distortion_y[i] * by_v[i];
  }
  ray->x_by_x = Scalar(1) + xu / h;
  ray->x_by_y = xv / h;
  ray->y_by_x = yu / h;
  ray->y_by_y = Scalar(1) + yv / h;
}
}  // namespace detail

template <class Scalar>
CameraRay<Scalar> ray_from_detector(const CameraGeometry<Scalar>& camera,
                                    const DetectorPosition<Scalar>& measured) {
  const DetectorPosition<Scalar> bend = detail::distortion(camera, measured);
  const Scalar x = measured.x_mm - camera.centre_x_mm + bend.x_mm;
  const Scalar y = measured.y_mm - camera.centre_y_mm + bend.y_mm;
  const detail::DetectorAxes<Scalar> axes = detail::detector_axes(camera);
  CameraRay<Scalar> ray;
  detail::distortion_slope(camera, measured, &ray);
  ray.origin = camera.centre;
  ray.direction = axes.z * camera.focal_mm + axes.x * x + axes.y * y;
  // Planes through the centre that hold the ray and one detector axis, scaled so that n_x . axes.x = 1.
  const Vector3<Scalar> n_x = cross(axes.y, ray.direction), n_y = cross(ray.direction, axes.x);
  ray.n_x = n_x * (Scalar(1) / dot(n_x, axes.x));
  ray.n_y = n_y * (Scalar(1) / dot(n_y, axes.y));
  return ray;
}

// Where a spot at `point` is measured; `in_view` is false behind the camera or off the detector.
template <class Scalar>
DetectorPosition<Scalar> project(const CameraGeometry<Scalar>& camera, const Vector3<Scalar>& point,
                                 bool* in_view) {
  const detail::DetectorAxes<Scalar> axes = detail::detector_axes(camera);
  const Vector3<Scalar> v = point - camera.centre;
  // v t = f z + x ex + y ey: dot with the detector's normal gives t, then x and y.
  const Vector3<Scalar> normal = cross(axes.x, axes.y);
  *in_view = false;
  const Scalar depth = dot(v, normal);
  if (!(depth > 0)) return {};
  const Scalar t = camera.focal_mm * dot(axes.z, normal) / depth;
  const Vector3<Scalar> on_detector = v * t - axes.z * camera.focal_mm;
  const DetectorPosition<Scalar> ideal{dot(on_detector, axes.x), dot(on_detector, axes.y)};
  // measured - centre + distortion(measured) = ideal, by fixed point: distortion's slope is a few per cent at
  // most.
  DetectorPosition<Scalar> measured{ideal.x_mm + camera.centre_x_mm, ideal.y_mm + camera.centre_y_mm};
  for (int iteration = 0; iteration < 12; ++iteration) {
    const DetectorPosition<Scalar> bend = detail::distortion(camera, measured);
    measured = {ideal.x_mm + camera.centre_x_mm - bend.x_mm, ideal.y_mm + camera.centre_y_mm - bend.y_mm};
  }
  const Scalar half = camera.half_size_mm;
  *in_view = within(measured.x_mm, half) && within(measured.y_mm, half);
  return measured;
}

}  // namespace tetragauge
