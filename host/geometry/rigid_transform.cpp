// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/geometry/rigid_transform.hpp"

#include <charconv>
#include <cmath>
#include <numbers>
#include <string>

namespace tetragauge {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

// Quarter turns are exact, so that a part placed by 90 degrees keeps its axis-parallel planes exactly.
std::pair<double, double> sine_cosine_deg(double deg) {
  const double turns = deg / 90.0;
  if (turns == std::round(turns) && std::abs(turns) < 1e9) {
    static constexpr double kSine[4] = {0, 1, 0, -1};
    const long quarter = ((std::lround(turns) % 4) + 4) % 4;
    return {kSine[quarter], kSine[(quarter + 1) % 4]};
  }
  return {std::sin(deg * kRadPerDeg), std::cos(deg * kRadPerDeg)};
}

}  // namespace

Mat3 rotation_from_degrees(double x_deg, double y_deg, double z_deg) {
  const auto [sx, cx] = sine_cosine_deg(x_deg);
  const auto [sy, cy] = sine_cosine_deg(y_deg);
  const auto [sz, cz] = sine_cosine_deg(z_deg);
  Mat3 Rx, Ry, Rz;
  Rx << 1, 0, 0, 0, cx, -sx, 0, sx, cx;
  Ry << cy, 0, sy, 0, 1, 0, -sy, 0, cy;
  Rz << cz, -sz, 0, sz, cz, 0, 0, 0, 1;
  return Rz * Ry * Rx;
}

Vec3 degrees_from_rotation(const Mat3& R) {
  const double y = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  double x = 0, z = 0;
  if (std::hypot(R(0, 0), R(1, 0)) > 1e-12) {
    x = std::atan2(R(2, 1), R(2, 2));
    z = std::atan2(R(1, 0), R(0, 0));
  } else {
    z = std::atan2(-R(0, 1), R(1, 1));
  }
  return Vec3(x, y, z) / kRadPerDeg;
}

double rotation_angle(const Mat3& R) {
  const Vec3 axis(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(0.5 * axis.norm(), 0.5 * (R.trace() - 1.0));
}

Result<RigidTransform> parse_pose(std::string_view text, std::string_view option) {
  const Error error =
      usage_error(std::string(option) + " " + std::string(text) +
                  ": expected six numbers RX,RY,RZ,TX,TY,TZ (degrees, mm), e.g. 90,0,0,0,0,0");
  std::array<double, 6> v{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (size_t i = 0; i < v.size(); ++i) {
    if (at != end && *at == '+') ++at;
    const auto [next, code] = std::from_chars(at, end, v[i]);
    if (code != std::errc{} || !std::isfinite(v[i])) return error;
    at = next;
    if (i + 1 < v.size()) {
      if (at == end || *at != ',') return error;
      ++at;
    }
  }
  if (at != end) return error;
  return RigidTransform{rotation_from_degrees(v[0], v[1], v[2]), Vec3(v[3], v[4], v[5])};
}

}  // namespace tetragauge
