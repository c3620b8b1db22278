// SPDX-License-Identifier: GPL-3.0-or-later
// Random trials of the match on face lists: a model's faces in any pose, some missing, some that are none of
// its own, all with noise.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/base/result.hpp"
#include "host/match/match.hpp"

namespace tetragauge::bench {

struct TrialNoise {
  double missing = 0.5;           // at most this share of the faces is missing
  double extra = 0.3;             // and this share of them is added
  double area = 0.2;              // areas are off by up to this share
  double normal_rad = 0.0174533;  // normals by up to this angle, in any direction
  double offset_mm = 0.3;         // planes by up to this much either way
};

struct Trial {
  std::string name;  // part and seed
  FaceList model, measured;
  std::vector<int> truth;  // per measured face the model's id; 0: an extra one
  RigidTransform T_model_part;
  std::string open;  // of a kept case: why it is not right yet
};

// Extra faces are random planes through the part's box, with areas of the part's own faces.
Trial random_trial(const std::string& part, const FaceList& model, uint64_t seed,
                   const TrialNoise& noise = {});

// Why no returned pose holds the true one within 1 degree and 1 mm, judged without the match's own scores.
enum class Miss {
  none,    // one does
  noise,   // a fit that knows every pair misses too
  chance,  // a returned pose puts more of the measured faces on model faces, within twice the trial's noise,
           // than the true one: an extra plane lies where the part has a face that was not seen
  fault,
};

struct TrialResult {
  Miss miss = Miss::fault;
  bool free_right = true;              // the free directions are those that brute force finds; if asked
  size_t equivalents_missed = 0;       // exact ones, by brute force, that were not returned; if asked
  double angle_deg = 0, shift_mm = 0;  // of the returned pose nearest to the true one
  size_t poses = 0;
  std::string error;   // of the match
  double time_ms = 0;  // processor time
};

// `with_oracle`: parts of up to 12 faces or so; it tries every assignment of three measured faces.
TrialResult run_trial(const Trial& trial, bool with_oracle);

// Motions of a planar part that put each face on one of the same area and centroid: by brute force over
// three of its faces.
std::vector<RigidTransform> symmetries(const FaceList& model);

double processor_ms();

// A case that can be run again: model, measured, truth and true pose as JSON.
Status write_trial(const std::filesystem::path& path, const Trial& trial, const std::string& what_failed);
Result<Trial> read_trial(const std::filesystem::path& path);

}  // namespace tetragauge::bench
