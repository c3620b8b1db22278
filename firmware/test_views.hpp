// SPDX-License-Identifier: Apache-2.0
// The view the firmware's tests scan: 11 x 7 rays, 2 mm apart, about the aim point.
#pragma once

#include "protocol/machine.pb.h"

namespace tetragauge {

inline tg_View small_view() {
  tg_View view = tg_View_init_zero;
  view.table_udeg = 30'000'000;
  view.slide_um = 100'000;
  view.a_first_urad = -15'000;
  view.b_first_urad = -9'000;
  view.a_step_urad = 3'000;
  view.b_step_urad = 3'000;
  view.columns = 11;
  view.rows = 7;
  view.samples = 4;
  return view;
}

inline constexpr uint32_t kSmallViewRays = 77;

}  // namespace tetragauge
