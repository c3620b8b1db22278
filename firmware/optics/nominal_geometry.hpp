// SPDX-License-Identifier: Apache-2.0
// The machine as drawn. One plate, 350 mm from the point aimed at, tilted 35 degrees down, carries the head
// in its middle and a camera on either side, all looking at the aim point, camera axes 45 degrees apart.
#pragma once

#include "firmware/optics/geometry.hpp"

namespace tetragauge {

inline constexpr double kHeadDistanceMm = 350;  // aim point to the last mirror
inline constexpr double kMirrorSeparationMm = 10;
// The aim point lies on the rotary axis. A part up to 200 mm tall shows its top at slide 0 and its foot at
// slide 200, and every height of it stands at the aim point within the slide's 300 mm.
inline constexpr double kAimHeightMm = 200;
inline constexpr double kCos35 = 0.81915204428899178968;
inline constexpr double kSin35 = 0.57357643635104609611;
inline constexpr double kCos22_5 = 0.92387953251128675613;
inline constexpr double kSin22_5 = 0.38268343236508977173;
inline constexpr double kSqrtHalf = 0.70710678118654752440;

template <class Scalar>
constexpr Vector3<Scalar> narrowed(const Vector3<double>& v) {
  return {static_cast<Scalar>(v.x), static_cast<Scalar>(v.y), static_cast<Scalar>(v.z)};
}

template <class Scalar>
constexpr MachineGeometry<Scalar> nominal_geometry() {
  // Head frame: forward along the undeflected beam, side to machine +y, up completes it (up = forward x side
  // reversed).
  constexpr Vector3<double> forward{-kCos35, 0, -kSin35};
  constexpr Vector3<double> side{0, 1, 0};
  constexpr Vector3<double> up{-kSin35, 0, kCos35};
  constexpr Vector3<double> aim{0, 0, kAimHeightMm};
  constexpr Vector3<double> head = aim - forward * kHeadDistanceMm;

  MachineGeometry<Scalar> machine;
  GalvoGeometry<Scalar>& galvo = machine.galvo;
  // The beam comes in from +y onto mirror a, goes down to mirror b, which sends it forward. Positive a swings
  // the beam to +y, positive b swings it up.
  galvo.beam_direction = narrowed<Scalar>(-side);
  galvo.a_point = narrowed<Scalar>(head + up * kMirrorSeparationMm);
  galvo.beam_point = narrowed<Scalar>(head + up * kMirrorSeparationMm + side * 30.0);
  galvo.a_axis = narrowed<Scalar>(-forward);
  galvo.a_normal = narrowed<Scalar>((side - up) * kSqrtHalf);
  galvo.b_point = narrowed<Scalar>(head);
  galvo.b_axis = narrowed<Scalar>(side);
  galvo.b_normal = narrowed<Scalar>((forward + up) * kSqrtHalf);
  // 8 urad of mirror angle is 16 urad of beam (galvanometer repeatability, docs/machine.md).
  galvo.direction_sigma_rad = static_cast<Scalar>(16e-6);

  for (int i = 0; i < 2; ++i) {
    CameraGeometry<Scalar>& camera = machine.camera[i];
    const double sign = i == 0 ? 1.0 : -1.0;
    // On the plate, where its axis through the aim point makes 22.5 degrees with the beam.
    const Vector3<double> axis = forward * kCos22_5 - side * (sign * kSin22_5);
    const Vector3<double> centre = aim - axis * (kHeadDistanceMm / kCos22_5);
    camera.centre = narrowed<Scalar>(centre);
    camera.y_axis = narrowed<Scalar>(up);
    camera.x_axis = narrowed<Scalar>(cross(up, axis));
    camera.focal_mm = static_cast<Scalar>(35);
    camera.half_size_mm = static_cast<Scalar>(10);  // 20 x 20 mm duolateral detector
    camera.dark_variance_codes2 = static_cast<Scalar>(2.33);
    camera.shot_variance_codes = static_cast<Scalar>(4e-5);
    // Speckle, which no averaging takes out: lambda f / (2 pi r) = 650 nm x 35 mm / (2 pi 8.75 mm), at any
    // distance (docs/machine.md).
    camera.position_sigma_mm = static_cast<Scalar>(0.000414);
  }

  machine.stage.axis_direction = {0, 0, 1};
  machine.stage.slide_direction = {0, 0, 1};
  machine.volume.min = {static_cast<Scalar>(-52), static_cast<Scalar>(-52), static_cast<Scalar>(-2)};
  machine.volume.max = {static_cast<Scalar>(52), static_cast<Scalar>(52), static_cast<Scalar>(202)};
  return machine;
}

}  // namespace tetragauge
