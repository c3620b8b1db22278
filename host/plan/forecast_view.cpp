// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/plan/forecast_view.hpp"

#include <tbb/parallel_for.h>

namespace tetragauge {

Result<std::vector<size_t>> forecast_view(const PlanningMachine& machine, const RayCaster& caster,
                                          size_t faces, const RigidTransform& T_part_model,
                                          const PlannedView& view, double max_incidence_rad) {
  const auto raster = lay_raster(machine.head, view);
  if (!raster) return raster.error();
  const HeadOverPart head(machine, T_part_model, {view.table_deg, view.slide_mm});
  std::vector<int> face_of_ray(size_t{raster->columns} * raster->rows, -1);
  tbb::parallel_for(uint32_t{0}, raster->rows, [&](uint32_t row) {
    for (uint32_t column = 0; column < raster->columns; ++column) {
      const MachineRay ray =
          head.beam(raster->a_first_urad + static_cast<int32_t>(column) * raster->a_step_urad,
                    raster->b_first_urad + static_cast<int32_t>(row) * raster->b_step_urad);
      const auto hit = caster.first_hit(ray.origin_mm, ray.direction);
      if (!hit || !head.look_along(caster, ray, *hit).within(max_incidence_rad)) continue;
      face_of_ray[size_t{row} * raster->columns + column] = hit->face;
    }
  });
  std::vector<size_t> points(faces, 0);
  for (const int face : face_of_ray)
    if (face >= 0) ++points[static_cast<size_t>(face)];
  return points;
}

}  // namespace tetragauge
