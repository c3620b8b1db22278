// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/deviation_ply.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/append_bytes.hpp"

namespace tetragauge {
namespace {

std::array<uint8_t, 3> colour(double share) {
  const double s = std::clamp(share, -1.0, 1.0);
  const auto byte = [](double x) { return static_cast<uint8_t>(std::lround(255 * std::clamp(x, 0.0, 1.0))); };
  // Through cyan and yellow, so that small deviations show too.
  return {byte(2 * s), byte(2 - 2 * std::abs(s)), byte(-2 * s)};
}

}  // namespace

std::string deviation_ply(const Report& report, double scale_mm) {
  const Inspection& inspection = report.run.inspection;
  std::string out =
      "ply\nformat binary_little_endian 1.0\ncomment frame part\ncomment unit mm\ncomment deviation from the "
      "model, + is excess "
      "material\nelement vertex " +
      std::to_string(inspection.point_face.size()) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar "
      "green\nproperty "
      "uchar blue\nproperty float deviation\nproperty int face\nend_header\n";
  size_t at = 0;
  for (size_t s = 0; s < report.scans.size(); ++s) {
    const RigidTransform T_first_this =
        report.run.set_ups.front().match.T_model_part.inverse() * report.run.set_ups[s].match.T_model_part;
    for (const Vec3& point : report.scans[s].points) {
      const Vec3 p = s == 0 ? point : T_first_this * point;
      for (int k = 0; k < 3; ++k) append_bytes(out, p[k]);
      const float deviation = inspection.point_deviation_mm[at];
      const int face = inspection.point_face[at];
      ++at;
      std::array<uint8_t, 3> rgb{128, 128, 128};
      if (face > 0) rgb = colour(static_cast<double>(deviation) / scale_mm);
      for (const uint8_t c : rgb) append_bytes(out, c);
      append_bytes(out, deviation);
      append_bytes(out, static_cast<int32_t>(face));
    }
  }
  return out;
}

}  // namespace tetragauge
