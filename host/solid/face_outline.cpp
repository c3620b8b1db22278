// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/solid/face_outline.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace tetragauge {

std::vector<FaceOutline> face_outlines(const Solid& model) {
  std::vector<FaceOutline> outlines(model.faces().size());
  std::vector<std::map<std::pair<uint32_t, uint32_t>, int>> edges(outlines.size());
  for (size_t k = 0; k < model.triangles.size(); ++k) {
    const auto& triangle = model.triangles[k];
    const size_t face = model.triangle_face[k];
    std::array<Vec3, 3> corners;
    for (size_t i = 0; i < 3; ++i) {
      corners[i] = model.vertices[triangle[i]];
      outlines[face].corners.push_back(corners[i]);
      ++edges[face][std::minmax(triangle[i], triangle[(i + 1) % 3])];
    }
    outlines[face].triangles.push_back(corners);
  }
  for (size_t face = 0; face < outlines.size(); ++face)
    for (const auto& [edge, uses] : edges[face])
      if (uses == 1)
        outlines[face].boundary.push_back({model.vertices[edge.first], model.vertices[edge.second]});
  return outlines;
}

std::vector<Vec3> samples_over(const FaceOutline& outline, size_t count) {
  double total = 0;
  const auto area = [](const std::array<Vec3, 3>& t) {
    return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
  };
  for (const auto& triangle : outline.triangles) total += area(triangle);
  std::vector<Vec3> samples;
  if (!(total > 0)) return samples;
  const double each = total / static_cast<double>(count);
  double owed = 0.5;  // carried from triangle to triangle: small ones get their share too
  for (const auto& t : outline.triangles) {
    owed += area(t) / each;
    const size_t n = static_cast<size_t>(owed);
    owed -= static_cast<double>(n);
    for (size_t k = 0; k < n; ++k) {
      // Evenly in a triangle: van der Corput points, folded (Basu and Owen, SIAM J. Numer. Anal. 53 (2015)
      // 743).
      double a = (static_cast<double>(k) + 0.5) / static_cast<double>(n), b = 0, digit = 0.5;
      for (size_t bits = k + 1; bits > 0; bits >>= 1, digit /= 2)
        if (bits & 1) b += digit;
      if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
      }
      samples.push_back(t[0] + a * (t[1] - t[0]) + b * (t[2] - t[0]));
    }
  }
  return samples;
}

std::vector<Vec3> samples_along(const FaceOutline& outline, double step_mm) {
  std::vector<Vec3> samples;
  for (const auto& [a, b] : outline.boundary) {
    const double steps = std::ceil(std::max(1.0, (b - a).norm() / step_mm));
    for (double k = 0; k <= steps; ++k) samples.push_back(a + (b - a) * (k / steps));
  }
  return samples;
}

}  // namespace tetragauge
