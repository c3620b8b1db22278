// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/scan_builder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace tetragauge {
namespace {

// A point is on the table's top when it lies no higher than its own noise allows, and never when it is
// clearly above.
constexpr double kTableSigmas = 5;
constexpr double kTableHeight_mm = 0.15;

// Standard uncertainty of the machine's geometry when no calibration says it. An emulated machine is built
// as it is configured: what is left (mirror codes of 12 urad of beam, coordinates in whole micrometres, the
// finite spot) is smaller than this. A real one gets the +-0.1 mm (95 %) of the thesis's machine.
constexpr double kEmulatedGeometry_mm = 0.005, kUncalibratedGeometry_mm = 0.05;

// Largest 1/e^2 radius of the beam in the working volume (docs/machine.md): 0.08 mm in the focus, Rayleigh
// length 31 mm (Siegman, Lasers, eq. 17.5), and corners of the volume's 100 x 100 mm 70 mm before and behind
// it.
constexpr double kSpot_mm = 0.2;

std::string hex(uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(value));
  return text;
}

ScanHeader header_of(const tg_HelloReply& machine, const ScanOptions& options) {
  ScanHeader header;
  header.machine_id = std::string(machine.board) + "/" + machine.firmware_version;
  const bool calibrated = machine.calibration_id[0] != '\0';
  const bool emulated = (machine.capabilities & tg_Capability_CAPABILITY_EMULATED) != 0;
  header.calibration_id = calibrated ? machine.calibration_id : hex(machine.config_crc);
  header.u_cal_mm = calibrated ? machine.u_cal_100nm * 1e-4
                    : emulated ? kEmulatedGeometry_mm
                               : kUncalibratedGeometry_mm;
  header.spot_mm = kSpot_mm;
  header.seed = options.seed;
  header.part_serial = options.part_serial;
  header.operator_name = options.operator_name;
  header.start_time = options.start_time;
  return header;
}

}  // namespace

ScanBuilder::ScanBuilder(HeadGeometry head, const tg_HelloReply& machine, const ScanOptions& options)
    : head_(std::move(head)), keep_table_(options.keep_table) {
  measured.scan.header = header_of(machine, options);
}

void ScanBuilder::take(const tg_PointBatch& batch, std::span<const BeamRecord> beams) {
  const RigidTransform T_part_machine =
      T_machine_part(head_, batch.table_udeg * 1e-6, batch.slide_um * 1e-3).inverse();
  for (const BeamRecord& beam : beams) {
    const MachineRay ray = ray_of_mirrors(head_, beam.a_urad, beam.b_urad);
    const Vec3 origin = T_part_machine * ray.origin_mm, direction = T_part_machine.R * ray.direction;
    ++measured.counts.beams;
    if (beam.reason == 0) {
      add_point(beam, T_part_machine * (1e-3 * Vec3(beam.x_um, beam.y_um, beam.z_um)), origin, direction);
    } else {
      measured.scan.rejected.push_back({origin, direction, beam.reason, beam.view});
      ++measured.counts.rejected[std::min<size_t>(beam.reason, measured.counts.rejected.size() - 1)];
    }
  }
}

void ScanBuilder::add_point(const BeamRecord& beam, const Vec3& point, const Vec3& origin,
                            const Vec3& direction) {
  const double sigma = 1e-4 * beam.sigma_100nm;
  ScanCounts& counts = measured.counts;
  if (!keep_table_ && point.z() < std::max(kTableHeight_mm, kTableSigmas * sigma * std::abs(direction.z()))) {
    ++counts.table_points;
    return;
  }
  Scan& scan = measured.scan;
  scan.points.push_back(point);
  scan.ray_origins.push_back(origin);
  scan.sigma_mm.push_back(static_cast<float>(sigma));
  scan.intensity.push_back(static_cast<float>(1e-3 * beam.intensity_permille));
  scan.view.push_back(beam.view);
  scan.flags.push_back(beam.flags);
  ++counts.points;
  if ((beam.flags & kPointUnsettled) != 0) ++counts.unsettled;
  if ((beam.flags & kPointOneCamera) != 0) ++counts.one_camera;
}

}  // namespace tetragauge
