// SPDX-License-Identifier: GPL-3.0-or-later
// A scan by ray casting alone: no firmware, no optics, only where a perfect sensor's beams end, and noise.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/base/result.hpp"
#include "host/geometry/rigid_transform.hpp"
#include "host/scan/scan.hpp"
#include "host/solid/ray_caster.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge {

// A window of beams about the line from the sensor to the part's middle.
struct BeamWindow {
  std::array<double, 2> angle_rad{};  // full angles across and up, below pi
  std::array<int, 2> rays{};          // evenly spread in angle, the ends included
};

// Displacement along the ray, evenly spread between two lengths. With low_mm >= 0 it goes either way by that
// much (as the thesis's "10 to 100 micrometres" did), otherwise it is signed.
struct UniformPerturbation {
  double low_mm = 0, high_mm = 0;
};

struct SimulateOptions {
  // View points around the part, in the scan frame: 6 along the axes, 8 over the corners of a cube, 14 both,
  // any other number on a spiral over the sphere.
  int views = 8;
  std::vector<Vec3> view_points_mm;  // scan frame; if any, these alone
  double pitch_mm = 1;               // spacing of the beams where they pass the middle of the part
  size_t points = 0;  // wanted number of points: chooses the pitch (within some per cent); 0: pitch_mm
  std::optional<BeamWindow> window;  // instead of pitch and points
  double sigma_mm = 0.02;            // one standard deviation along the ray
  std::optional<UniformPerturbation>
      perturbation;  // instead of sigma; its rms is then the sigma of the points
  uint64_t seed = 1;
  RigidTransform T_scan_model;
  double max_incidence_rad = 1.4;  // 80 degrees: a beam flatter to the face than that gives no point
  double standoff_mm = 0;          // sensor to the middle of the part; 0: four times the part's radius
  bool keep_rejected = false;      // beams without a point, as evidence of free space
};

// Error (usage) for options that make no sense, or when no beam meets the part.
Result<Scan> simulate(const Solid& solid, const RayCaster& caster, const SimulateOptions& options = {});

// Unit vectors from the part to the view points.
std::vector<Vec3> view_directions(int views);

}  // namespace tetragauge
