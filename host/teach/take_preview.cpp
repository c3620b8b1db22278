// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "host/session/head_geometry.hpp"
#include "host/session/plan_limits.hpp"
#include "host/session/prepare_machine.hpp"
#include "host/teach/preview.hpp"

namespace tetragauge {
namespace {

// As the survey of an unknown part: enough to see it.
constexpr uint32_t kSamples = 8;

PlannedView coarse(const PlannedView& view, const PreviewSize& size) {
  const RasterWindow& w = view.window;
  const auto spacing = [](double span_mm, size_t number) {
    return span_mm / static_cast<double>(std::max<size_t>(number, 2) - 1);
  };
  PlannedView quick = view;
  quick.pitch_mm = std::clamp(
      std::max(spacing(w.y_max_mm - w.y_min_mm, size.columns), spacing(w.up_max_mm - w.up_min_mm, size.rows)),
      kFinestPitch_mm, kCoarsestPitch_mm);
  quick.samples = kSamples;
  return quick;
}

// Puts beams back to their places in the raster: by their mirror angles, in which it is regular.
class Placer {
 public:
  Placer(const HeadGeometry& head, const tg_View& raster, const PlannedView& view)
      : head_(head),
        raster_(raster),
        T_machine_part_(T_machine_part(head, view.table_deg, view.slide_mm)),
        reach_mm_((head.aim_mm - ray_of_mirrors(head, 0, 0).origin_mm).norm()) {}

  // The cell of a beam, part frame; nullptr: none, which no beam of the raster is.
  PreviewCell* place(const Vec3& origin, const Vec3& direction, Preview& preview) const {
    const Vec3 at = T_machine_part_ * (origin + reach_mm_ * direction);
    const auto angles = aim_mirrors(head_.galvo, Vector3<double>{at.x(), at.y(), at.z()});
    const auto index = [](double rad, int32_t first_urad, int32_t step_urad) {
      return step_urad == 0 ? 0 : std::lround((rad * 1e6 - first_urad) / step_urad);
    };
    const long column = index(angles.a_rad, raster_.a_first_urad, raster_.a_step_urad);
    const long row = index(angles.b_rad, raster_.b_first_urad, raster_.b_step_urad);
    if (column < 0 || row < 0 || column >= static_cast<long>(preview.columns) ||
        row >= static_cast<long>(preview.rows))
      return nullptr;
    const size_t from_top = preview.rows - 1 - static_cast<size_t>(row);
    return &preview.cells[from_top * preview.columns + static_cast<size_t>(column)];
  }

  // Where a beam meets the aim plane.
  void widen(const Vec3& origin, const Vec3& direction, RasterWindow& window) const {
    const Vec3 from = T_machine_part_ * origin - head_.aim_mm, along = T_machine_part_.R * direction;
    const Vec3 normal = head_.y.cross(head_.up);
    const Vec3 at = from - along * (from.dot(normal) / along.dot(normal));
    window.y_min_mm = std::min(window.y_min_mm, at.dot(head_.y));
    window.y_max_mm = std::max(window.y_max_mm, at.dot(head_.y));
    window.up_min_mm = std::min(window.up_min_mm, at.dot(head_.up));
    window.up_max_mm = std::max(window.up_max_mm, at.dot(head_.up));
  }

 private:
  const HeadGeometry& head_;
  const tg_View& raster_;
  RigidTransform T_machine_part_;
  double reach_mm_;
};

// The part may go on for a spacing beyond its outermost points.
RasterWindow with_margin(RasterWindow window, double pitch_mm) {
  const auto outwards = [&](double value, double by) {
    return std::clamp(std::round(value + by), -kWindowReach_mm, kWindowReach_mm);
  };
  return {.y_min_mm = outwards(window.y_min_mm, -pitch_mm),
          .y_max_mm = outwards(window.y_max_mm, pitch_mm),
          .up_min_mm = outwards(window.up_min_mm, -pitch_mm),
          .up_max_mm = outwards(window.up_max_mm, pitch_mm)};
}

}  // namespace

Result<Preview> take_preview(Link& link, const PlannedView& view, const PreviewSize& size,
                             const ScanOptions& options) {
  const PlannedView quick = coarse(view, size);
  const auto config = read_head_config(link);
  if (!config) return config.error();
  const HeadGeometry head = head_geometry(config->galvo, config->stage);
  const auto raster = lay_raster(head, quick);
  if (!raster) return raster.error();
  const auto measured = run_scan(link, {.views = {quick}}, options);
  if (!measured) return measured.error();

  Preview preview;
  preview.view = view;
  preview.columns = raster->columns;
  preview.rows = raster->rows;
  preview.cells.resize(preview.columns * preview.rows);
  const Placer placer(head, *raster, quick);
  const Scan& scan = measured->scan;
  preview.points = scan.size();
  RasterWindow around{.y_min_mm = 1e9, .y_max_mm = -1e9, .up_min_mm = 1e9, .up_max_mm = -1e9};
  for (size_t i = 0; i < scan.size(); ++i) {
    placer.widen(scan.ray_origins[i], scan.ray_direction(i), around);
    PreviewCell* const cell = placer.place(scan.ray_origins[i], scan.ray_direction(i), preview);
    if (!cell) continue;
    *cell = {.kind = PreviewCell::Kind::point,
             .intensity = scan.intensity[i],
             .range_mm = (scan.points[i] - scan.ray_origins[i]).norm()};
  }
  for (const RejectedBeam& beam : scan.rejected) {
    PreviewCell* const cell = placer.place(beam.origin, beam.direction, preview);
    if (cell) *cell = {.kind = PreviewCell::Kind::rejected, .reason = beam.reason};
  }
  preview.seen = scan.size() > 0 ? with_margin(around, quick.pitch_mm) : view.window;
  return preview;
}

}  // namespace tetragauge
