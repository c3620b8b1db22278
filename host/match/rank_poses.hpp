// SPDX-License-Identifier: GPL-3.0-or-later
// From candidate poses to the best one and those that the faces cannot tell from it.
#pragma once

#include <vector>

#include "host/match/match.hpp"
#include "host/match/pair_planes.hpp"

namespace tetragauge {

// Poses ruled out that are worth telling.
inline constexpr size_t kMostRuledOut = 4;

struct RankedPose {
  RefinedPose pose;
  std::vector<PlanePair> pairs;
  double cost = 0;   // sum of face_costs, all poses with the same scatter
  double doubt = 0;  // standard deviations by which more rays contradict it than the best
};

struct RankedPoses {
  // By cost; no two are the same pose; none costs more than the best by `within` or more.
  std::vector<RankedPose> poses;
  // Poses that cost more, though they explain almost as much: of a near-symmetric part. By cost.
  std::vector<RankedPose> rivals;
  double scatter_mm = 0, scatter_rad = 0;  // that all costs were taken with
  size_t compared = 0;
};

// The two lists as the search sees them.
struct MatchInput {
  const FaceList& model_list;
  const FaceList& measured_list;
  const MatchOptions& options;
  PlaneSet model, measured;
  SearchGates gates;
  ScatterPrior prior;
};

// Normals of one face, measured and modelled, farther apart are not of one face: twice what a degree of noise
// in the thesis's worst face (1.5 degrees) needs.
inline constexpr double kDefaultMaxAngle_rad = 3.5 * 0.017453292519943295;
// A tenth of a degree: what one drawing would not call the same direction is not.
inline constexpr double kModelDirection_rad = 1.75e-3;
inline constexpr double kDefaultMaxOffset = 0.015;  // of the part's size

// Two poses whose costs differ by less are not told apart: a likelihood ratio of e^4.5, about one in a
// hundred.
inline constexpr double kSameCost = 9;

// Errors: no planes to match; a rule names a face that is none.
Result<MatchInput> match_input(const FaceList& model, const FaceList& measured, const MatchOptions& options);
Result<PlaneSet> model_planes(const FaceList& model);
Result<PlaneSet> measured_planes(const FaceList& measured);

// Of the candidates that explain most at most `most_candidates` are looked at.
RankedPoses rank_poses(const MatchInput& input, double within, size_t most_candidates = 300);

// Nothing of the measured faces fits anywhere on the model.
Error no_pose_error(const PlaneSet& model, const PlaneSet& measured, const SearchGates& gates = {});

// Writes pairs, what is left over on either side and the free directions, for the pose in `match`.
void write_pairs(const PlaneSet& model, const PlaneSet& measured, const std::vector<PlanePair>& pairs,
                 const std::vector<bool>& used, Match& match);

// Chooses among `poses` (all of which the data cannot tell apart) the one nearest to no rotation, and writes
// down the others with the reason, the rivals with what rules them out, and what is misplaced. `ranked` must
// not be empty.
Match conclude_match(const MatchInput& input, const RankedPoses& ranked);

}  // namespace tetragauge
