// SPDX-License-Identifier: GPL-3.0-or-later
// The thesis's matching, kept as it was (Cakir, University of Bath, 1989): each plane becomes one vector, its
// normal scaled by distance and area, and the two sets of vectors are turned onto each other.
#pragma once

#include "host/match/match.hpp"

namespace tetragauge {

struct ProcrustesOptions {
  // After a turn: break all links and link anew by distance, or break only those longer than the minimum
  // between the two modes of the density of their lengths.
  enum class Links { all, modes } links = Links::all;
  PairRules rules;
};

struct ProcrustesMatch {
  Match match;                                   // no covariance, no equivalents: the method knows of none
  Vec3 plane_centre_model_mm = Vec3::Zero();     // model frame
  Vec3 plane_centre_measured_mm = Vec3::Zero();  // part frame
  double residual = 0;                           // 0: the vectors lie on each other; 1: nothing linked
  int half_turn_axis = 0;                        // of the retry that won: 0 none, 1 x, 2 y, 3 z
};

// Distance is counted from the plane centre outwards, so neither list need tell the side of the material.
// Areas are taken as they are in the lists: `faces` already measures them to the edges where planes meet,
// without the false chamfers. Errors: no planes to match;
// a rule names a face that is none.
Result<ProcrustesMatch> match_procrustes(const FaceList& model, const FaceList& measured,
                                         const ProcrustesOptions& options = {});

}  // namespace tetragauge
