// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/torus_crossings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetragauge {
namespace {

struct Value {
  double f = 0, slope = 0;
};

// The root between low and high, where `function` changes sign: Newton's steps as long as they stay within
// and shrink the bracket well, halves of it otherwise (Press et al., Numerical Recipes, section 9.4).
template <class Function>
double root_between(const Function& function, double low, double high) {
  const bool is_rising = function(low).f < 0;
  const double rounding = 2e-16 * std::max(std::abs(low), std::abs(high));
  double s = 0.5 * (low + high), last_step = high - low;
  for (int round = 0; round < 200; ++round) {
    const auto [f, slope] = function(s);
    if (f == 0) return s;
    ((f < 0) == is_rising ? low : high) = s;
    const double newton = s - f / slope;
    if (std::abs(newton - s) <= rounding) return s;
    const bool is_good = newton > low && newton < high && std::abs(newton - s) <= 0.5 * last_step;
    const double next = is_good ? newton : 0.5 * (low + high);
    last_step = std::abs(next - s);
    if (next == s || !(next > low && next < high)) return s;
    s = next;
  }
  return s;
}

// Ascending, within [low, high].
struct Stops {
  std::array<double, 5> s{};
  size_t count = 0;
  void add(double value) { s[count++] = value; }
};

// The zeros of c[0] + c[1] s + c[2] s^2 + c[3] s^3 where it changes sign, with both ends: between its turning
// points, which are the zeros of a quadratic, it is monotonic.
Stops sign_changes(const std::array<double, 4>& c, double low, double high) {
  Stops turns;
  turns.add(low);
  const double a = 3 * c[3], b = c[2], discriminant = b * b - a * c[1];  // a s^2 + 2 b s + c[1]
  if (discriminant > 0 && a != 0) {
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    const double one = q / a, other = q != 0 ? c[1] / q : one;
    for (const double turn : {std::min(one, other), std::max(one, other)}) {
      if (turn > low && turn < high) turns.add(turn);
    }
  }
  turns.add(high);
  const auto cubic = [&](double s) {
    return Value{((c[3] * s + c[2]) * s + c[1]) * s + c[0], (3 * c[3] * s + 2 * c[2]) * s + c[1]};
  };
  Stops stops;
  stops.add(low);
  for (size_t i = 0; i + 1 < turns.count; ++i) {
    const double from = cubic(turns.s[i]).f, to = cubic(turns.s[i + 1]).f;
    if (from == 0 || (from < 0) == (to < 0)) continue;
    stops.add(root_between(cubic, turns.s[i], turns.s[i + 1]));
  }
  stops.add(high);
  return stops;
}

}  // namespace

TorusCrossings torus_crossings(const Face& face, const Vec3& p, const Vec3& direction) {
  const double R = face.radius_mm, a = face.minor_radius_mm;
  // From the point nearest to the centre, in which s is small: no digits are lost.
  const double s0 = -(p - face.point_on_axis_mm).dot(direction);
  const Vec3 r = p - face.point_on_axis_mm + s0 * direction;
  const double reach_sq = (R + a) * (R + a) - r.squaredNorm();
  TorusCrossings crossings;
  if (reach_sq <= 0) return crossings;
  const double reach = std::sqrt(reach_sq) * (1 + 1e-9) + 1e-9 * R;
  const double square = r.squaredNorm(), z = face.axis.dot(r), w = face.axis.dot(direction);
  // Only between the two planes that touch the tube.
  double low = -reach, high = reach;
  const double half = a * (1 + 1e-9) + 1e-9 * R;
  if (w == 0 && std::abs(z) > half) return crossings;
  if (w != 0) {
    const double one = (-half - z) / w, other = (half - z) / w;
    low = std::max(low, std::min(one, other));
    high = std::min(high, std::max(one, other));
  }
  if (!(low < high)) return crossings;
  // The quartic's derivative: (s^2 + k)^2 = 4 R^2 (s^2 + |r|^2 - (z + w s)^2), k = |r|^2 + R^2 - a^2, for |r
  // + s d|^2 = s^2 + |r|^2.
  const double k = square + R * R - a * a, four = 4 * R * R;
  const std::array<double, 4> derivative{2 * four * z * w, 4 * k - 2 * four * (1 - w * w), 0, 4};
  // Its turning points split the line; the crossings themselves are taken on the distance to the tube, whose
  // rounding is that of a length and not of its fourth power.
  const auto distance = [&](double s) {
    const Vec3 q = r + s * direction;
    const double along = face.axis.dot(q);
    const Vec3 across = q - face.axis * along;
    const double radius = across.norm(), from_ring = radius - R;
    const double from_middle = std::sqrt(from_ring * from_ring + along * along);
    const double growth = radius > 0 ? across.dot(direction) / radius : 0;
    return Value{from_middle - a, (from_ring * growth + along * w) / std::max(from_middle, 1e-9 * a)};
  };
  const Stops stops = sign_changes(derivative, low, high);
  for (size_t i = 0; i + 1 < stops.count && crossings.count < 4; ++i) {
    const bool is_from_inside = distance(stops.s[i]).f < 0, is_to_inside = distance(stops.s[i + 1]).f < 0;
    if (is_from_inside == is_to_inside) continue;
    crossings.s[crossings.count] = s0 + root_between(distance, stops.s[i], stops.s[i + 1]);
    crossings.is_inward[crossings.count++] = is_to_inside;
  }
  return crossings;
}

}  // namespace tetragauge
