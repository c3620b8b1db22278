// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/reconstruct/mass_properties.hpp"

namespace tetragauge {

MassProperties mass_properties(const Tetrahedra& tetrahedra, const std::vector<uint8_t>& air) {
  MassProperties result;
  if (tetrahedra.vertices.empty()) return result;
  const Vec3 base = tetrahedra.vertices.front();  // keeps the sums small far from the origin
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (size_t c = 0; c < tetrahedra.cells.size(); ++c) {
    const Cell& cell = tetrahedra.cells[c];
    if (air[c] || cell.is_infinite()) continue;
    Vec3 v[4], sum = Vec3::Zero();
    for (size_t i = 0; i < 4; ++i) {
      v[i] = tetrahedra.vertices[cell.vertex[i]] - base;
      sum += v[i];
    }
    const double volume = (v[1] - v[0]).cross(v[2] - v[0]).dot(v[3] - v[0]) / 6;
    result.volume_mm3 += volume;
    first += volume / 4 * sum;
    // Integral of x x^T over a tetrahedron: V/20 (sum_i v_i v_i^T + (sum v)(sum v)^T).
    Mat3 squares = sum * sum.transpose();
    for (const Vec3& p : v) squares += p * p.transpose();
    second += volume / 20 * squares;
  }
  if (!(result.volume_mm3 > 0)) return result;
  const Vec3 centre = first / result.volume_mm3;
  result.centroid_mm = base + centre;
  const Mat3 central = second - result.volume_mm3 * centre * centre.transpose();
  result.inertia_mm5 = central.trace() * Mat3::Identity() - central;
  return result;
}

}  // namespace tetragauge
