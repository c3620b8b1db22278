// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/match/faces_out.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetragauge {
namespace {

constexpr double kLeastOfFace = 30;  // points, to tell whether it is out of place

}  // namespace

std::map<int, double> faces_out(const std::vector<RayResidual>& residuals, const SurfaceScatter& scatter,
                                double most_out_mm) {
  std::map<int, std::vector<double>> offsets;
  std::map<int, double> variance;
  for (const RayResidual& r : residuals) {
    if (!r.near || r.face < 0) continue;
    offsets[r.face].push_back(r.offset_mm);
    variance[r.face] += r.variance_mm2 + scatter.scatter_mm * scatter.scatter_mm;
  }
  std::map<int, double> out;
  for (auto& [face, of_face] : offsets) {
    const auto count = static_cast<double>(of_face.size());
    if (count < kLeastOfFace) continue;
    // A median of normal errors scatters pi / 2 times as much, squared, as their mean.
    const double chance = 0.5 * std::numbers::pi * scatter.together * variance[face] / (count * count);
    const double off = median(std::move(of_face));
    if (off * off > kMostSurprise * chance && std::abs(off) <= most_out_mm) out[face] = off;
  }
  return out;
}

double share_against(const std::vector<RayResidual>& residuals, const SurfaceScatter& scatter,
                     double limit_mm, double most_out_mm) {
  if (residuals.empty()) return 0;
  const std::map<int, double> out = faces_out(residuals, scatter, most_out_mm);
  size_t against = 0;
  for (const RayResidual& r : residuals) {
    const double limit = std::max(limit_mm, std::sqrt(kMostSurprise * r.variance_mm2));
    against += !r.near || std::abs(offset_as_made(r, out)) > limit || r.behind_mm > limit;
  }
  return static_cast<double>(against) / static_cast<double>(residuals.size());
}

}  // namespace tetragauge
