// SPDX-License-Identifier: GPL-3.0-or-later
// All scans of a part brought together in the model frame, each by its own match.
#pragma once

#include <span>
#include <vector>

#include "host/inspect/cast_scan.hpp"
#include "host/inspect/inspect.hpp"

namespace tetragauge {

struct MeasuredPatch {
  size_t set_up = 0;
  int measured_id = 0;        // there
  int model_id = 0;           // the face it was matched to; 0: none
  bool is_misplaced = false;  // of a feature in the wrong place
  double area_mm2 = 0;
  std::vector<uint32_t> points;  // of JoinedScan, ascending
};

struct JoinedScan {
  CastScan cast;                       // all points, the scans one after the other
  std::vector<uint32_t> set_up;        // per point
  std::vector<MeasuredPatch> patches;  // by set-up, then as matched
  double u_cal_mm = 0;                 // the largest of the scans'
  double spot_mm = 0;                  // likewise
  double max_offset_mm = 0;            // farther from its place a face was not taken for that face
  std::vector<bool> held;              // per model face, see held_faces
  bool is_free_to_shift = false;       // a pose has a free translation: where faces end is not known
  bool is_determined = true;           // no pose has a free direction, or only one that moves no face
};

JoinedScan join_set_ups(std::span<const Scan> scans, const Solid& model, const RayCaster& caster,
                        const std::vector<SetUp>& set_ups);

}  // namespace tetragauge
