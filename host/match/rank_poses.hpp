// SPDX-License-Identifier: GPL-3.0-or-later
// From candidate poses to the best one and those that the faces cannot tell from it.
#pragma once

#include <vector>

#include "host/match/match.hpp"
#include "host/match/pair_planes.hpp"

namespace tetragauge {

struct RankedPose {
  RefinedPose pose;
  std::vector<PlanePair> pairs;
  double cost = 0;  // pose_cost, all poses with the same scatter
};

struct RankedPoses {
  // By cost; no two are the same pose; none costs more than the best by `within` or more.
  std::vector<RankedPose> poses;
  size_t compared = 0;
};

// Normals of one face, measured and modelled, farther apart are not of one face: twice what a degree of noise
// in the thesis's worst face (1.5 degrees) needs.
inline constexpr double kDefaultMaxAngle_rad = 3.5 * 0.017453292519943295;

// Two poses whose costs differ by less are not told apart: a likelihood ratio of e^4.5, about one in a
// hundred.
inline constexpr double kSameCost = 9;

RankedPoses rank_poses(const PlaneSet& model, const PlaneSet& measured, const SearchGates& gates,
                       double within);

SearchGates search_gates(const PlaneSet& model, const MatchOptions& options);
// Errors: no planes to match.
Result<PlaneSet> model_planes(const FaceList& model);
Result<PlaneSet> measured_planes(const FaceList& measured);

// Nothing of the measured faces fits anywhere on the model.
Error no_pose_error(const PlaneSet& model, const PlaneSet& measured);

// Chooses among `poses` (all of which the data cannot tell apart) the one nearest to no rotation, and writes
// down the others with the reason. `ranked` must not be empty.
Match conclude_match(const PlaneSet& model, const PlaneSet& measured, const SearchGates& gates,
                     const RankedPoses& ranked);

}  // namespace tetragauge
