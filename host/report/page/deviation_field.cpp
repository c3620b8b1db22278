// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/report/page/deviation_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

namespace tetragauge {
namespace {

constexpr double kNear = 2.5;      // in spacings: no point within that is a gap
constexpr double kFarthest = 8.0;  // in spacings: a mean over more would hide form
constexpr double kCalm = 0.1;      // the mean's noise, in limits: hardly a colour

// How many spacings a mean must reach to be calm. The biweight's effective number of points is 5 pi / 9 of
// those in a square of the reach.
double reach_in_spacings(double noise_mm, double limit_mm) {
  if (!(limit_mm > 0)) return kNear;
  const double wanted = std::pow(noise_mm / (kCalm * limit_mm), 2);
  return std::clamp(std::sqrt(wanted * 9 / (5 * std::numbers::pi)), kNear, kFarthest);
}

// A face's points by cubes of side `reach_mm`; all that are nearer than that lie in the 27 cubes about a
// place.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<std::pair<Vec3, double>>& values, double near_mm, double reach_mm)
      : near_mm_(near_mm), reach_mm_(reach_mm) {
    for (const auto& [p, value] : values) entries_.push_back({cell(p), p, value});
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.cell < b.cell; });
  }

  // Nearer points weigh more: (1 - r^2)^2, the biweight. NaN when none is near.
  double mean(const Vec3& p) const {
    double sum = 0, weights = 0;
    bool is_near = false;
    const auto [x, y, z] = cell(p);
    for (int64_t i = x - 1; i <= x + 1; ++i) {
      for (int64_t j = y - 1; j <= y + 1; ++j) {
        const Cell first{i, j, z - 1}, last{i, j, z + 1};  // neighbours along z lie side by side
        auto at = std::lower_bound(entries_.begin(), entries_.end(), first,
                                   [](const Entry& entry, const Cell& cell) { return entry.cell < cell; });
        for (; at != entries_.end() && at->cell <= last; ++at) {
          const double squared = (at->point - p).squaredNorm();
          const double inside = 1 - squared / (reach_mm_ * reach_mm_);
          if (inside <= 0) continue;
          is_near |= squared < near_mm_ * near_mm_;
          sum += inside * inside * at->value;
          weights += inside * inside;
        }
      }
    }
    return is_near ? sum / weights : std::numeric_limits<double>::quiet_NaN();
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

  double near_mm_, reach_mm_;
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
    const double limit = offset_limit(report.tolerances.of(report.model.faces()[k]));
    const double reach =
        reach_in_spacings(inspection.faces[k].rms_mm, limit < 1e300 ? limit : 0) * spacing_mm;
    fields.emplace_back(of_face[k], kNear * spacing_mm, std::max(1e-9, reach));
  }
  std::vector<float> field;
  field.reserve(mesh.vertices.size());
  for (size_t v = 0; v < mesh.vertices.size(); ++v)
    field.push_back(static_cast<float>(fields[mesh.vertex_face[v]].mean(mesh.vertices[v])));
  return field;
}

}  // namespace tetragauge
