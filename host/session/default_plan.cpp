// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/session/default_plan.hpp"

#include <algorithm>
#include <cmath>

#include "host/session/prepare_machine.hpp"

namespace tetragauge {
namespace {

constexpr double kSurveyPitch_mm = 4;
// What the survey may have missed beside its outermost points.
constexpr double kMargin_mm = 1.5 * kSurveyPitch_mm;
constexpr int kTableAngles = 8;
// Height of a part seen at one slide position: 100 mm at the aim point, and as far to the front and the back
// as the working volume goes, stay within the cameras' +-108 mm.
constexpr double kSlab_mm = 100;
constexpr double kAimHeight_mm = 200, kVolumeHeight_mm = 200;

ScanPlan survey_plan() {
  ScanPlan plan;
  for (const double height_mm : {0.25 * kVolumeHeight_mm, 0.75 * kVolumeHeight_mm}) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      PlannedView view;
      view.table_deg = 90.0 * quarter;
      view.slide_mm = kAimHeight_mm - height_mm;
      view.pitch_mm = kSurveyPitch_mm;
      view.samples = 8;
      plan.views.push_back(view);
    }
  }
  return plan;
}

}  // namespace

ScanPlan plan_around(const HeadGeometry& head, std::span<const Vec3> seen,
                     const DefaultPlanOptions& options) {
  const auto lower = [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); };
  const double top_mm =
      std::min(std::max_element(seen.begin(), seen.end(), lower)->z() + kSurveyPitch_mm, kVolumeHeight_mm);
  const int slabs = std::max(1, static_cast<int>(std::ceil(top_mm / kSlab_mm)));
  ScanPlan plan;
  for (int slab = 0; slab < slabs; ++slab) {
    const double low_mm = top_mm * slab / slabs, high_mm = top_mm * (slab + 1) / slabs;
    for (int k = 0; k < kTableAngles; ++k) {
      PlannedView view;
      view.table_deg = 360.0 * k / kTableAngles;
      view.slide_mm = std::round(10 * (kAimHeight_mm - 0.5 * (low_mm + high_mm))) / 10;
      view.pitch_mm = options.pitch_mm;
      view.samples = options.samples;
      const RigidTransform T = T_machine_part(head, view.table_deg, view.slide_mm);
      RasterWindow whole = view.window;
      RasterWindow& w = view.window;
      w = {.y_min_mm = 1e9, .y_max_mm = -1e9, .up_min_mm = 1e9, .up_max_mm = -1e9};
      for (const Vec3& p : seen) {
        if (p.z() < low_mm - kMargin_mm || p.z() > high_mm + kMargin_mm) continue;
        // Seen from the mirrors, onto the aim plane.
        const Vec3 at = T * p - head.aim_mm;
        const Vec3 toward = head.y.cross(head.up);
        const MachineRay rest = ray_of_mirrors(head, 0, 0);
        const double distance = (rest.origin_mm - head.aim_mm).dot(toward);
        const double to_plane = distance / (distance - at.dot(toward));
        w.y_min_mm = std::min(w.y_min_mm, at.dot(head.y) * to_plane - kMargin_mm);
        w.y_max_mm = std::max(w.y_max_mm, at.dot(head.y) * to_plane + kMargin_mm);
        w.up_min_mm = std::min(w.up_min_mm, at.dot(head.up) * to_plane - kMargin_mm);
        w.up_max_mm = std::max(w.up_max_mm, at.dot(head.up) * to_plane + kMargin_mm);
      }
      if (w.y_min_mm > w.y_max_mm) continue;  // nothing of the part at this height
      w.y_min_mm = std::max(w.y_min_mm, whole.y_min_mm - kMargin_mm);
      w.y_max_mm = std::min(w.y_max_mm, whole.y_max_mm + kMargin_mm);
      w.up_min_mm = std::max(w.up_min_mm, whole.up_min_mm - kMargin_mm);
      w.up_max_mm = std::min(w.up_max_mm, whole.up_max_mm + kMargin_mm);
      plan.views.push_back(view);
    }
  }
  return plan;
}

Result<MeasuredScan> survey_volume(Link& link, const ScanOptions& scan) {
  if (scan.log) scan.log("survey of the working volume");
  ScanOptions quick = scan;
  quick.keep_table = false;
  quick.journal = nullptr;
  if (scan.on_progress) {
    quick.on_progress = [&](ScanProgress progress) {
      progress.survey = true;
      scan.on_progress(progress);
    };
  }
  auto survey = run_scan(link, survey_plan(), quick);
  if (!survey) return survey.error();
  if (survey->scan.points.empty()) {
    return machine_error(link.device() + ": there is no part on the table (the survey saw " +
                         std::to_string(survey->counts.table_points) +
                         " points of the table only); put one on it, or give a plan with --plan");
  }
  return survey;
}

Result<ScanPlan> default_plan(Link& link, const DefaultPlanOptions& options, const ScanOptions& scan) {
  const auto survey = survey_volume(link, scan);
  if (!survey) return survey.error();
  const auto config = read_head_config(link);
  if (!config) return config.error();
  return plan_around(head_geometry(config->galvo, config->stage), survey->scan.points, options);
}

}  // namespace tetragauge
