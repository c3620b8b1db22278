// SPDX-License-Identifier: Apache-2.0
// The machine's geometry as the firmware believes it: machine frame, mm, radians. nominal_geometry.hpp has
// the default.
#pragma once

#include <cstdint>

#include "firmware/optics/vector.hpp"

namespace tetragauge {

// Two mirrors. At angle zero of both, the ray along beam_direction through beam_point meets mirror a, then
// mirror b (the last). A mirror is a plane through its point, which lies on its rotation axis; a positive
// angle turns it right-handed about the axis.
template <class Scalar>
struct GalvoGeometry {
  Vector3<Scalar> beam_point, beam_direction;
  Vector3<Scalar> a_point, a_axis, a_normal;
  Vector3<Scalar> b_point, b_axis, b_normal;
  Scalar a_zero_rad{}, b_zero_rad{};  // true angle = scale * commanded + zero
  Scalar a_scale{1}, b_scale{1};
  Scalar direction_sigma_rad{};  // repeatability of the beam's direction, standard deviation across the beam
};

inline constexpr int kDistortionTerms = 7;

// How a detector's four electrodes share the photocurrent.
enum class Detector : uint8_t {
  kDuolateral,    // each pair carries all of it: x = h (x2 - x1) / (x1 + x2), y alike
  kTetralateral,  // all four share it: x = h (x2 - x1) / (x1 + x2 + y1 + y2); its pin-cushion is distortion
};

// A position-sensitive detector behind a lens.
template <class Scalar>
struct CameraGeometry {
  Detector detector = Detector::kDuolateral;
  Vector3<Scalar> centre;          // of projection
  Vector3<Scalar> x_axis, y_axis;  // along the detector; x cross y looks out into the scene
  Scalar focal_mm{};
  Scalar tilt_x_rad{}, tilt_y_rad{};    // of the detector about the camera's x and y
  Scalar centre_x_mm{}, centre_y_mm{};  // electrical centre relative to the optical axis
  Scalar half_size_mm{};                // signal +-1 is this far from the centre
  Scalar
      distortion_x[kDistortionTerms]{};  // mm at the detector's edge, of u^2, uv, v^2, u^3, u^2 v, u v^2, v^3
  Scalar distortion_y[kDistortionTerms]{};  // with u, v the measured position over half_size, -1 .. 1
  Scalar dark_variance_codes2{};            // one sample of one channel
  Scalar shot_variance_codes{};             // added per code of light on that channel
  Scalar position_sigma_mm{};               // on the detector; averaging does not lower it
};

template <class Scalar>
struct StageGeometry {
  Vector3<Scalar> axis_point, axis_direction;  // rotary axis at slide zero
  Vector3<Scalar> slide_direction;
};

template <class Scalar>
struct VolumeBox {  // part frame
  Vector3<Scalar> min, max;
};

template <class Scalar>
struct MachineGeometry {
  GalvoGeometry<Scalar> galvo;
  CameraGeometry<Scalar> camera[2];  // 0 on the side of +y
  StageGeometry<Scalar> stage;
  VolumeBox<Scalar> volume;
};

}  // namespace tetragauge
