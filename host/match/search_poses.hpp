// SPDX-License-Identifier: GPL-3.0-or-later
// Every pose that explains much of the measured area, with no start: rotations from pairs of directions with
// equal angles, translations by consensus over the offsets, both searched completely.
#pragma once

#include <vector>

#include "host/geometry/rigid_transform.hpp"
#include "host/match/allowed_pairs.hpp"
#include "host/match/plane_set.hpp"

namespace tetragauge {

struct SearchGates {
  double offset_mm = 0;
  double angle_rad = 0;
  bool is_unsigned = false;
  AllowedPairs allowed;
};

// A pair that a person has fixed may be this many gates from its place: he knows what the search cannot. A
// pose in which it is farther is not considered.
inline constexpr double kFixedGates = 4;

// Whether every fixed pair is within its wider gates; the offset only if `T.t` counts.
bool holds_fixed(const PlaneSet& model, const PlaneSet& measured, const RigidTransform& T,
                 const SearchGates& gates, bool with_offset);

struct PoseCandidate {
  RigidTransform T_model_part;
  double explained = 0;  // weight of the measured faces on a model face, less for what fits badly
};

// Measured faces may add up to this much more than the model's area on the same plane before the rest counts
// as unexplained (measured areas are off by some 20 %; seen in part they are smaller, never much larger).
inline constexpr double kAreaSlack = 1.25;

// By explained area, descending; only those that explain at least `keep` of the best one's.
std::vector<PoseCandidate> search_poses(const PlaneSet& model, const PlaneSet& measured,
                                        const SearchGates& gates, double keep);

struct RotationCandidate {
  Mat3 R = Mat3::Identity();  // model from part
  double explained = 0;       // by direction alone: no translation can explain more
};

// Rotations from all pairs among the first `measured_directions` directions, best first, each once.
// One direction alone (or opposing ones) gives the smallest turn that aligns it.
std::vector<RotationCandidate> search_rotations(const PlaneSet& model, const PlaneSet& measured,
                                                size_t measured_directions, const SearchGates& gates);

// All translations for one rotation that explain at least `at_least`, and `keep` of what the best of them
// does.
std::vector<PoseCandidate> search_translations(const PlaneSet& model, const PlaneSet& measured, const Mat3& R,
                                               const SearchGates& gates, double at_least, double keep);

}  // namespace tetragauge
