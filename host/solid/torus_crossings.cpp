// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/torus_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetragauge {
namespace {

// c[0] + c[1] s + c[2] s^2 + ...
double value_of(const double* c, size_t degree, double s) {
  double value = c[degree];
  for (size_t k = degree; k-- > 0;) value = value * s + c[k];
  return value;
}

// The root between low and high, where `f` changes sign: bisection until no number lies between, which regula
// falsi speeds up where it can.
template <class Function>
double root_between(const Function& f, double low, double high) {
  double f_low = f(low), f_high = f(high);
  for (int step = 0; step < 200; ++step) {
    double middle = 0.5 * (low + high);
    if (step % 3 != 0) {
      const double secant = low - f_low * (high - low) / (f_high - f_low);
      if (secant > low && secant < high) middle = secant;
    }
    if (!(middle > low && middle < high)) break;
    const double f_middle = f(middle);
    if (f_middle == 0) return middle;
    const bool is_low = (f_middle < 0) == (f_low < 0);
    (is_low ? low : high) = middle;
    (is_low ? f_low : f_high) = f_middle;
  }
  return std::abs(f_low) < std::abs(f_high) ? low : high;
}

// Real roots of a polynomial within [low, high], ascending: between the roots of its derivative it is
// monotonic.
std::vector<double> roots_of(const double* c, size_t degree, double low, double high) {
  std::array<double, 5> derivative{};
  for (size_t k = 1; k <= degree; ++k) derivative[k - 1] = static_cast<double>(k) * c[k];
  std::vector<double> stops{low};
  if (degree > 1) {
    const std::vector<double> turns = roots_of(derivative.data(), degree - 1, low, high);
    stops.insert(stops.end(), turns.begin(), turns.end());
  }
  stops.push_back(high);
  std::vector<double> roots;
  const auto f = [&](double s) { return value_of(c, degree, s); };
  for (size_t i = 0; i + 1 < stops.size(); ++i) {
    const double from = f(stops[i]), to = f(stops[i + 1]);
    if (from == 0 || (from < 0) == (to < 0)) continue;
    roots.push_back(root_between(f, stops[i], stops[i + 1]));
  }
  return roots;
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
  // (s^2 + k)^2 = 4 R^2 (s^2 + |r|^2 - (z + w s)^2), k = |r|^2 + R^2 - a^2, for |r + s d|^2 = s^2 + |r|^2.
  const double square = r.squaredNorm(), z = face.axis.dot(r), w = face.axis.dot(direction);
  const double k = square + R * R - a * a, four = 4 * R * R;
  const std::array<double, 5> quartic{k * k - four * (square - z * z), 2 * four * z * w,
                                      2 * k - four * (1 - w * w), 0, 1};
  // Its turning points split the line; the crossings themselves are taken on the distance to the tube, whose
  // rounding is that of a length and not of its fourth power.
  const auto distance = [&](double s) {
    const Vec3 q = r + s * direction;
    const double along = face.axis.dot(q);
    return std::hypot((q - face.axis * along).norm() - R, along) - a;
  };
  std::array<double, 5> derivative{};
  for (size_t i = 1; i <= 4; ++i) derivative[i - 1] = static_cast<double>(i) * quartic[i];
  std::vector<double> stops = roots_of(derivative.data(), 3, -reach, reach);
  stops.insert(stops.begin(), -reach);
  stops.push_back(reach);
  for (size_t i = 0; i + 1 < stops.size() && crossings.count < 4; ++i) {
    const bool is_from_inside = distance(stops[i]) < 0, is_to_inside = distance(stops[i + 1]) < 0;
    if (is_from_inside == is_to_inside) continue;
    crossings.s[crossings.count] = s0 + root_between(distance, stops[i], stops[i + 1]);
    crossings.is_inward[crossings.count++] = is_to_inside;
  }
  return crossings;
}

}  // namespace tetragauge
