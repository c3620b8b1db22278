// SPDX-License-Identifier: GPL-3.0-or-later
// Single directions, measured: to look again at chosen places without a raster around them.
//
//   std::vector<SingleRay> rays = {{.table_deg = 45, .slide_mm = 175, .a_urad = 12'000, .b_urad = -3'000}};
//   auto measured = measure_rays(link, rays);      // a scan: points with rays, rejected beams
//
// Rays of one table angle and slide height are one view of the scan, in the order of the list; views are
// numbered as their first rays come in it. A list longer than the machine holds is measured in several runs.
#pragma once

#include <span>

#include "host/session/plan.hpp"
#include "host/session/run_scan.hpp"

namespace tetragauge {

struct SingleRay {
  double table_deg = 0, slide_mm = 0;
  // Mirror angles; the mirrors go to the nearest they can.
  int32_t a_urad = 0, b_urad = 0;
};

// Homes the machine if need be. `samples`: as PlannedView's. No journal is kept: options.journal must be
// null. Errors (bad input): a direction beyond the mirrors' limit, named by its number in the list, from 1.
Result<MeasuredScan> measure_rays(Link& link, std::span<const SingleRay> rays,
                                  uint32_t samples = PlannedView{}.samples, const ScanOptions& options = {});

}  // namespace tetragauge
