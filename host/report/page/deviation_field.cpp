// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/deviation_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace tetragauge {
namespace {

constexpr double kReach =
    2.5;  // in spacings: some 20 points, so that their mean's noise is under a quarter of one's

// A face's points by cubes of side `reach_mm`; all that are nearer than that lie in the 27 cubes about a
// place.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<std::pair<Vec3, double>>& values, double reach_mm) : reach_mm_(reach_mm) {
    for (const auto& [p, value] : values) entries_.push_back({cell(p), p, value});
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.cell < b.cell; });
  }

  // Nearer points weigh more: (1 - r^2)^2, the biweight.
  double mean(const Vec3& p) const {
    double sum = 0, weights = 0;
    const auto [x, y, z] = cell(p);
    for (int64_t i = x - 1; i <= x + 1; ++i) {
      for (int64_t j = y - 1; j <= y + 1; ++j) {
        const Cell first{i, j, z - 1}, last{i, j, z + 1};  // neighbours along z lie side by side
        auto at = std::lower_bound(entries_.begin(), entries_.end(), first,
                                   [](const Entry& entry, const Cell& cell) { return entry.cell < cell; });
        for (; at != entries_.end() && at->cell <= last; ++at) {
          const double inside = 1 - (at->point - p).squaredNorm() / (reach_mm_ * reach_mm_);
          if (inside <= 0) continue;
          sum += inside * inside * at->value;
          weights += inside * inside;
        }
      }
    }
    return weights > 0 ? sum / weights : std::numeric_limits<double>::quiet_NaN();
  }

 private:
  using Cell = std::tuple<int64_t, int64_t, int64_t>;
  struct Entry {
    Cell cell;
    Vec3 point;
    double value;
  };
  Cell cell(const Vec3& p) const {
    const auto along = [&](int axis) { return static_cast<int64_t>(std::floor(p[axis] / reach_mm_)); };
    return {along(0), along(1), along(2)};
  }

  double reach_mm_;
  std::vector<Entry> entries_;
};

}  // namespace

std::vector<float> deviation_field(const DisplayMesh& mesh, const Report& report,
                                   std::span<const Vec3> points) {
  const Inspection& inspection = report.run.inspection;
  std::vector<std::vector<std::pair<Vec3, double>>> of_face(report.model.faces().size());
  for (size_t i = 0; i < points.size(); ++i)
    if (inspection.point_face[i] > 0)
      of_face[static_cast<size_t>(inspection.point_face[i]) - 1].emplace_back(
          points[i], static_cast<double>(inspection.point_deviation_mm[i]));
  std::vector<Neighbourhood> fields;
  for (size_t k = 0; k < of_face.size(); ++k) {
    const double area_mm2 = report.model.faces()[k].area_mm2 * std::max(0.05, inspection.faces[k].coverage);
    const double spacing_mm =
        std::sqrt(area_mm2 / static_cast<double>(std::max<size_t>(1, of_face[k].size())));
    fields.emplace_back(of_face[k], std::max(1e-9, kReach * spacing_mm));
  }
  std::vector<float> field;
  field.reserve(mesh.vertices.size());
  for (size_t v = 0; v < mesh.vertices.size(); ++v)
    field.push_back(static_cast<float>(fields[mesh.vertex_face[v]].mean(mesh.vertices[v])));
  return field;
}

}  // namespace tetragauge
