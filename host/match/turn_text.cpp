// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/turn_text.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tetragauge {
namespace {

// Entries within a hundredth of the largest count as large: noise must not choose among them.
constexpr double kAsLarge = 0.99;

}  // namespace

std::string number_text(double value, int decimals) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  const std::string out = text.data();
  const bool is_minus_zero = out[0] == '-' && out.find_first_not_of("-0.") == std::string::npos;
  return is_minus_zero ? out.substr(1) : out;
}

Vec3 canonical_axis(const Vec3& axis) {
  const double largest = axis.cwiseAbs().maxCoeff();
  for (int k = 0; k < 3; ++k)
    if (std::abs(axis[k]) >= kAsLarge * largest) return axis[k] < 0 ? Vec3(-axis) : axis;
  return axis;
}

std::string vector_text(const Vec3& v, int decimals) {
  return "(" + number_text(v.x(), decimals) + ", " + number_text(v.y(), decimals) + ", " +
         number_text(v.z(), decimals) + ")";
}

std::string turn_text(const Mat3& R) {
  const Eigen::AngleAxisd turn(R);
  const Vec3 axis = canonical_axis(turn.axis());
  std::string degrees = number_text(turn.angle() * 180 / std::numbers::pi, 1);
  const bool is_whole = degrees == "0.0" || degrees == "180.0";
  if (!is_whole && axis.dot(turn.axis()) < 0) degrees.insert(0, "-");
  return "turned by " + degrees + " degrees about " + vector_text(axis, 3);
}

std::string motion_text(const RigidTransform& motion) {
  const bool turns = number_text(rotation_angle(motion.R) * 180 / std::numbers::pi, 1) != "0.0";
  return turns ? turn_text(motion.R) : "shifted by " + vector_text(motion.t, 1) + " mm";
}

}  // namespace tetragauge
