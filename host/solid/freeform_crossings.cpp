// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/freeform_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetragauge {
namespace {

// The mesher turns by 0.35 rad from a triangle to the next at most: a line steeper than that to the triangle
// crosses its piece once.
constexpr double kSteep = 0.4;  // sine of the angle to the triangle

// How far beyond its triangle, in shares of it, Newton's steps may look: a crossing beyond is another
// triangle's.
constexpr double kBeyond = 0.5;

// A step this small is the last; far below a micrometre, above rounding at 1 m.
constexpr double kArrived_mm = 1e-9;

// Enough for the halving of a double zero's distance down to kArrived_mm from a millimetre.
constexpr int kMostSteps = 40;

// Weights of the corners 1 and 2; that of corner 0 is the rest.
using Weights = std::array<double, 2>;

bool is_near(const Weights& w) {
  return w[0] >= -kBeyond && w[1] >= -kBeyond && w[0] + w[1] <= 1 + kBeyond;
}

SurfaceParameters parameters_at(const FreeformPiece& piece, const Weights& w) {
  const auto& [zero, one, two] = piece.parameters;
  SurfaceParameters uv;
  for (size_t i = 0; i < 2; ++i) uv[i] = zero[i] + w[0] * (one[i] - zero[i]) + w[1] * (two[i] - zero[i]);
  return uv;
}

// The surface over the weights.
SurfacePoint at_weights(const FreeformPiece& piece, const Weights& w) {
  const SurfacePoint raw = piece.surface->at(parameters_at(piece, w));
  const auto along = [&](size_t corner) {
    return Vec3(raw.du * (piece.parameters[corner][0] - piece.parameters[0][0]) +
                raw.dv * (piece.parameters[corner][1] - piece.parameters[0][1]));
  };
  return {raw.point_mm, along(1), along(2)};
}

// Newton's steps for surface(w) = p + s * direction.
std::optional<FreeformCrossing> arrive(const FreeformPiece& piece, const Vec3& p, const Vec3& direction,
                                       Weights w, double s) {
  const double extent_mm = (piece.corners[1] - piece.corners[0]).cwiseAbs().maxCoeff() +
                           (piece.corners[2] - piece.corners[0]).cwiseAbs().maxCoeff();
  for (int step = 0; step < kMostSteps; ++step) {
    const SurfacePoint on = at_weights(piece, w);
    const Vec3 off = p + s * direction - on.point_mm;
    const Vec3 n = on.du.cross(on.dv);
    const double closing = n.dot(direction);
    if (closing == 0) return std::nullopt;
    // Solved by Cramer's rule: du w0 + dv w1 - direction ds = off.
    const double ds = -n.dot(off) / closing;
    const Vec3 in_plane = off + ds * direction;
    const double square = n.squaredNorm();
    w[0] += in_plane.cross(on.dv).dot(n) / square;
    w[1] += on.du.cross(in_plane).dot(n) / square;
    s += ds;
    if (!is_near(w) || !(std::abs(ds) <= 4 * extent_mm)) return std::nullopt;
    if (std::abs(ds) > kArrived_mm || in_plane.norm() > kArrived_mm) continue;
    const Vec3 outward =
        (piece.corners[1] - piece.corners[0]).cross(piece.corners[2] - piece.corners[0]).dot(n) < 0 ? Vec3(-n)
                                                                                                    : n;
    return FreeformCrossing{s, p + s * direction, outward.normalized()};
  }
  return std::nullopt;
}

}  // namespace

FreeformCrossings freeform_crossings(const FreeformPiece& piece, const Vec3& p, const Vec3& direction) {
  FreeformCrossings result;
  const Vec3 a = piece.corners[1] - piece.corners[0], b = piece.corners[2] - piece.corners[0];
  const Vec3 n = a.cross(b);
  const double square = n.squaredNorm();
  if (!(square > 0)) return result;
  const double norm = std::sqrt(square), closing = n.dot(direction) / norm;
  // Height over the triangle's plane, and the weights below, are linear along the line.
  const Vec3 r = p - piece.corners[0];
  const double height = n.dot(r) / norm;
  const Weights start{r.cross(b).dot(n) / square, a.cross(r).dot(n) / square};
  const Weights growth{direction.cross(b).dot(n) / square, a.cross(direction).dot(n) / square};
  const auto weights_at = [&](double s) {
    return Weights{start[0] + s * growth[0], start[1] + s * growth[1]};
  };
  const auto take = [&](double s) {
    const auto found = arrive(piece, p, direction, weights_at(s), s);
    if (!found) return;
    if (result.count == 1 && std::abs(result.crossings[0].s - found->s) < 10 * kArrived_mm) return;
    result.crossings[result.count++] = *found;
  };
  if (!is_flat(n, direction)) {
    const double s = -height / closing;
    // The surface over the triangle is this near along the line.
    if (is_near(weights_at(s))) take(s);
    return result;
  }
  double low = -1e300, high = 1e300;
  const auto clip = [&](double value, double slope, double from, double to) {
    if (slope == 0) {
      if (value < from || value > to) high = low - 1;
      return;
    }
    const double one = (from - value) / slope, other = (to - value) / slope;
    low = std::max(low, std::min(one, other));
    high = std::min(high, std::max(one, other));
  };
  clip(height, closing, -piece.height_mm, piece.height_mm);
  clip(start[0], growth[0], -kBeyond, 1 + kBeyond);
  clip(start[1], growth[1], -kBeyond, 1 + kBeyond);
  clip(start[0] + start[1], growth[0] + growth[1], -kBeyond, 1 + kBeyond);
  if (!(low <= high)) return result;
  take(low);
  take(high);
  return result;
}

bool is_flat(const Vec3& triangle_normal, const Vec3& direction) {
  return std::abs(triangle_normal.dot(direction)) <= kSteep * triangle_normal.norm();
}

double freeform_height_mm(const FreeformPiece& piece) {
  const Vec3 n =
      (piece.corners[1] - piece.corners[0]).cross(piece.corners[2] - piece.corners[0]).normalized();
  double height = 0;
  for (const Weights& w : {Weights{1.0 / 3, 1.0 / 3}, Weights{0.5, 0}, Weights{0, 0.5}, Weights{0.5, 0.5}}) {
    const Vec3 point = piece.surface->at(parameters_at(piece, w)).point_mm;
    height = std::max(height, std::abs(n.dot(point - piece.corners[0])));
  }
  return 2 * height;
}

}  // namespace tetragauge
