// SPDX-License-Identifier: Apache-2.0
// From the samples of one ray to its point, or the reason why there is none.
#pragma once

#include "firmware/measure/ray_samples.hpp"
#include "firmware/optics/geometry.hpp"
#include "protocol/beam_record.hpp"

namespace tetragauge {

// float: the machine's processor computes it in hardware, and its rounding (under 1 um over the working
// volume, solve_spot_test.cpp) is far below a spot's sigma.
using MachineScalar = float;

struct RayPlace {
  uint32_t view = 0, ray = 0;
  int32_t a_urad = 0, b_urad = 0;  // as driven
  bool settled = true;
};

struct StagePlace {
  MachineScalar table_rad{}, slide_mm{};
};

BeamRecord judge_ray(const MachineGeometry<MachineScalar>& machine, const tg_MeasureConfig& config,
                     const StagePlace& stage, const RayPlace& place, const RaySamples& samples);

}  // namespace tetragauge
