// SPDX-License-Identifier: GPL-3.0-or-later
// The rounds of re-measurement: what an inspection leaves in doubt is shot at again, in the same session, and
// all is inspected anew, until nothing is left in doubt that the machine could decide.
#pragma once

#include <functional>
#include <optional>

#include "host/measure/doubts.hpp"
#include "host/session/run_scan.hpp"

namespace tetragauge {

struct ImproveOptions {
  int rounds = 2;       // at most: what two did not decide is seldom worth the next one's time
  double budget_s = 0;  // of the machine's time for all of them; 0: as long as they take
  PlanPartOptions plan;
  InspectOptions inspect;
};

// The part so far: whole after the first scan, better after each round.
struct PartInProgress {
  Scan scan;
  ScanCounts counts;
  uint32_t views = 0;  // numbered so far
  InspectionRun run;
};

// Changes `part` and tells in `story` what each round changed. An error of the machine (also when asked to
// stop) ends the rounds: it is returned, and `part` holds, inspected, all that was measured before.
std::optional<Error> improve_scan(Link& link, const PlanningMachine& machine, const Solid& model,
                                  const RayCaster& caster, const Tolerances& tolerances,
                                  const ImproveOptions& options, const ScanOptions& scan,
                                  PartInProgress& part, MeasuringStory& story);

}  // namespace tetragauge
