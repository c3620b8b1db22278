// SPDX-License-Identifier: GPL-3.0-or-later
// Which measured face is which model face, in a given pose, and what the pose leaves unexplained.
#pragma once

#include <vector>

#include "host/match/refine_pose.hpp"
#include "host/match/search_poses.hpp"

namespace tetragauge {

struct PlanePair {
  size_t model = 0, measured = 0;  // indices into PlaneSet::planes
  bool flipped = false;            // the measured normal points into the material (unsigned lists)
};

// Measured faces on one model face that agree within this are pieces of it (a patch of a fillet or a bore is
// not).
struct FragmentLimits {
  double offset_mm = 0;
  double angle_rad = 0;  // or four of their own standard uncertainties
};

// At most one pair per measured face, ascending by model, then measured. The plane decides; among patches of
// one plane the nearest centroid. Several measured faces on one model face are kept as its fragments only if
// they agree on where it is within `fragment`; otherwise the larger one has it, unless it fits much worse.
std::vector<PlanePair> pair_planes(const PlaneSet& model, const PlaneSet& measured,
                                   const RigidTransform& T_model_part, const SearchGates& gates,
                                   const FragmentLimits& fragment);

std::vector<PlaneObservation> observations(const PlaneSet& model, const PlaneSet& measured,
                                           const std::vector<PlanePair>& pairs);

// The most a single face can say against a pose: five standard deviations, squared. Well above what a good
// face costs by chance (3 on average, 16 once in a thousand), so that one face can decide.
inline constexpr double kFaceCost = 25;

// What each measured face says against a pose: min(r' C^-1 r, kFaceCost), r the offset and tilts on the
// paired model face and C their covariance with the given scatter; kFaceCost where there is none; and its
// share of a penalty where the faces of one plane have more area than the model. Small faces count for less.
// The difference of two poses' sums is a log-likelihood ratio, times two.
std::vector<double> face_costs(const PlaneSet& model, const PlaneSet& measured,
                               const RigidTransform& T_model_part, const std::vector<PlanePair>& pairs,
                               double scatter_mm, double scatter_rad);

}  // namespace tetragauge
