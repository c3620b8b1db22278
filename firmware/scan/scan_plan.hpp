// SPDX-License-Identifier: Apache-2.0
// The scan's views as the host loaded them, and the walk over their rays.
#pragma once

#include "firmware/machine_config.hpp"

namespace tetragauge {

inline constexpr uint32_t kMaxViews = 256;
inline constexpr uint32_t kMaxRaysPerView = 4'000'000;
inline constexpr uint32_t kMaxSamples = 4096;

struct RayTarget {
  int32_t a_urad = 0, b_urad = 0;
};

// Boustrophedon: row by row, odd rows backwards. As View in machine.proto says.
constexpr RayTarget target_of(const tg_View& view, uint32_t ray) {
  const uint32_t row = ray / view.columns;
  const uint32_t along = ray % view.columns;
  const uint32_t column = row % 2 == 0 ? along : view.columns - 1 - along;
  return {view.a_first_urad + static_cast<int32_t>(column) * view.a_step_urad,
          view.b_first_urad + static_cast<int32_t>(row) * view.b_step_urad};
}

constexpr uint32_t rays_of(const tg_View& view) {
  return view.columns * view.rows;
}

class ScanPlan {
 public:
  struct Trouble {
    const char* what = "";
    uint32_t view = 0;
  };
  // REFUSE_NONE when the chunk was taken; a refused one changes nothing. The first chunk (first_view 0)
  // starts a new plan.
  tg_RefuseReason load(const tg_ScanLoad& chunk, const MachineConfig& config, Trouble* trouble);
  void forget() { plan_id_ = total_ = loaded_ = 0; }

  uint32_t plan_id() const { return plan_id_; }
  uint32_t views_loaded() const { return loaded_; }
  uint32_t views() const { return total_; }
  bool complete() const { return total_ > 0 && loaded_ == total_; }
  const tg_View& view(uint32_t index) const { return views_[index]; }

 private:
  uint32_t plan_id_ = 0, total_ = 0, loaded_ = 0;
  tg_View views_[kMaxViews] = {};
};

// Null when the view can be measured, else what is wrong.
const char* view_error(const tg_View& view, const MachineConfig& config);

}  // namespace tetragauge
