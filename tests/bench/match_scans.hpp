// SPDX-License-Identifier: GPL-3.0-or-later
// The match on simulated scans: is the pose right, how far off is it beside the Cramer-Rao bound of the data,
// and do its covariances tell the truth.
#pragma once

#include <cstdint>
#include <string>

#include "host/base/result.hpp"
#include "host/geometry/rigid_transform.hpp"
#include "host/solid/solid.hpp"

namespace tetragauge::bench {

struct ScanTrialOptions {
  size_t points = 5000;
  double sigma_mm = 0.03;
  bool from_two_sides = false;  // otherwise all round
  uint64_t seed = 1;            // of pose and noise
};

struct ScanTrial {
  bool right = false;  // within 0.1 degrees and 0.1 mm (or ten times the bound) of the truth, up to symmetry
  size_t poses = 0;    // returned
  size_t free_directions = 0;
  double shift_um = 0, turn_urad = 0;              // of the chosen pose, about the part's centroid
  double bound_shift_um = 0, bound_turn_urad = 0;  // Cramer-Rao: rms over the three axes together
  // e' C^-1 e over its degrees of freedom, C the bound: 1 on average for an efficient estimator.
  double ratio2_bound = 0;
  double mahalanobis2 = 0;  // with the match's own covariance; 6 degrees of freedom
  double match_s = 0;       // processor time of match_scan
  std::string error;
};

Result<ScanTrial> scan_trial(const Solid& solid, const ScanTrialOptions& options);

}  // namespace tetragauge::bench
