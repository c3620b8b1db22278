// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/points_in_model.hpp"

namespace tetragauge {

std::vector<Vec3> points_in_model(const Report& report) {
  std::vector<Vec3> points;
  points.reserve(report.run.inspection.point_face.size());
  for (size_t s = 0; s < report.scans.size(); ++s)
    for (const Vec3& point : report.scans[s].points)
      points.push_back(report.run.set_ups[s].match.T_model_part * point);
  return points;
}

}  // namespace tetragauge
