// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/scan/pick_points.hpp"

namespace tetragauge {

Scan pick_points(const Scan& scan, std::span<const uint32_t> points) {
  Scan result;
  result.header = scan.header;
  const auto pick = [&](const auto& from, auto& to) {
    to.reserve(points.size());
    for (const uint32_t i : points) to.push_back(from[i]);
  };
  pick(scan.points, result.points);
  pick(scan.ray_origins, result.ray_origins);
  pick(scan.sigma_mm, result.sigma_mm);
  pick(scan.intensity, result.intensity);
  pick(scan.view, result.view);
  pick(scan.flags, result.flags);
  return result;
}

}  // namespace tetragauge
