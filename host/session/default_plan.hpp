// SPDX-License-Identifier: GPL-3.0-or-later
// A plan for a part nobody has described: a quick coarse survey of the whole working volume finds where the
// part is, and the views are laid around what it saw: 8 table angles, as many slide heights as the part's
// height needs, each window just as large as the part looks from there.
//
//   auto plan = default_plan(link);
#pragma once

#include <span>

#include "host/session/head_geometry.hpp"
#include "host/session/run_scan.hpp"

namespace tetragauge {

struct DefaultPlanOptions {
  double pitch_mm = 1;
  uint32_t samples = PlannedView{}.samples;
};

Result<ScanPlan> default_plan(Link& link, const DefaultPlanOptions& options = {},
                              const ScanOptions& scan = {});

// The two halves of it. The survey: 4 table angles, the whole volume, 4 mm pitch, few samples. Error
// (machine): it saw nothing but the table. Keeps no journal.
Result<MeasuredScan> survey_volume(Link& link, const ScanOptions& scan = {});
// `seen`: points of the part, part frame. Precondition: not empty.
ScanPlan plan_around(const HeadGeometry& head, std::span<const Vec3> seen, const DefaultPlanOptions& options);

}  // namespace tetragauge
