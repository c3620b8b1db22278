// SPDX-License-Identifier: GPL-3.0-or-later
// A scan: measured points, each with the ray it was measured along, in the part frame (mm).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/geometry/vec.hpp"

namespace tetragauge {

// Point flags, as the firmware sets them (protocol/machine.proto, PointFlag).
enum PointFlag : uint32_t {
  kPointUnsettled = 1,  // the mirrors had not come to rest
  kPointOneCamera = 2,  // solved from the beam and one camera
  kPointWeak = 4,       // little light
};

// A beam that gave no point.
struct RejectedBeam {
  Vec3 origin = Vec3::Zero();     // mm
  Vec3 direction = Vec3::Zero();  // unit
  uint32_t reason = 0;            // protocol/machine.proto, RejectReason
  uint32_t view = 0;
};

struct ScanHeader {
  std::string frame = "part";
  std::string machine_id;
  std::string calibration_id;
  double u_cal_mm = 0;  // standard uncertainty of the machine's geometry; 0 for simulate
  double spot_mm = 0;   // largest 1/e^2 radius of the beam on the part; 0: rays have no width (simulate)
  std::optional<uint64_t> seed;
  std::string part_serial, operator_name, start_time;  // start_time for real hardware only
};

// Structure of arrays; all of size() entries.
struct Scan {
  ScanHeader header;
  std::vector<Vec3> points;       // mm
  std::vector<Vec3> ray_origins;  // mm: the point on the last mirror, or the sensor
  std::vector<float> sigma_mm;    // one standard deviation ALONG THE RAY
  std::vector<float> intensity;
  std::vector<uint32_t> view;
  std::vector<uint32_t> flags;
  std::vector<RejectedBeam> rejected;

  size_t size() const { return points.size(); }
  // Unit direction of the measuring ray, from its origin to the point.
  Vec3 ray_direction(size_t i) const { return (points[i] - ray_origins[i]).normalized(); }
};

}  // namespace tetragauge
