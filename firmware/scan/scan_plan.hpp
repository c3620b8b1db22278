// SPDX-License-Identifier: Apache-2.0
// The scan's views as the host loaded them, and the walk over their rays. A view is a raster (ScanLoad) or a
// list of single directions (MeasureRays); one plan may hold both.
//
//   plan.load(chunk, config, &trouble);             // either kind, in order, until plan.complete()
//   for (uint32_t v = 0; v < plan.views(); ++v) {
//     for (uint32_t ray = 0; ray < plan.rays(v); ++ray) measure(plan.target(v, ray));
//   }
#pragma once

#include "firmware/hal/board.hpp"
#include "firmware/machine_config.hpp"

namespace tetragauge {

inline constexpr uint32_t kMaxViews = 256;
inline constexpr uint32_t kMaxRaysPerView = 4'000'000;
inline constexpr uint32_t kMaxSamples = 4096;
inline constexpr uint32_t kMaxListedRays = 2048;  // of all listed views together
// A raw view's whole ray is kept until the host has room for it.
inline constexpr uint32_t kMaxRawSamples = 128;

struct RayTarget {
  int32_t a_urad = 0, b_urad = 0;
};

// The code nearest to an angle, of those a converter with every `step`-th of them can do.
constexpr int32_t mirror_code(int32_t urad, int32_t step = 1) {
  const int32_t urad_a_step = kUradPerMirrorCode * step;
  const int32_t half = urad_a_step / 2;
  return (urad + (urad < 0 ? -half : half)) / urad_a_step * step;
}

// A listed view has rows = 0.
constexpr bool is_listed(const tg_View& view) {
  return view.rows == 0;
}

constexpr uint32_t rays_of(const tg_View& view) {
  return is_listed(view) ? view.columns : view.columns * view.rows;
}

// Of a raster. Boustrophedon: row by row, odd rows backwards. As View in machine.proto says.
constexpr RayTarget target_of(const tg_View& view, uint32_t ray) {
  const uint32_t row = ray / view.columns;
  const uint32_t along = ray % view.columns;
  const uint32_t column = row % 2 == 0 ? along : view.columns - 1 - along;
  return {view.a_first_urad + static_cast<int32_t>(column) * view.a_step_urad,
          view.b_first_urad + static_cast<int32_t>(row) * view.b_step_urad};
}

class ScanPlan {
 public:
  struct Trouble {
    const char* what = "";
    uint32_t view = 0;
  };
  // REFUSE_NONE when the chunk was taken; a refused one changes nothing. The first chunk (of view 0, and
  // there of ray 0) starts a new plan; each later one goes on where the one before it ended.
  tg_RefuseReason load(const tg_ScanLoad& chunk, const MachineConfig& config, Trouble* trouble);
  tg_RefuseReason load(const tg_MeasureRays& chunk, const MachineConfig& config, Trouble* trouble);
  void forget() { plan_id_ = total_ = loaded_ = listed_ = listed_of_view_ = 0; }

  uint32_t plan_id() const { return plan_id_; }
  uint32_t views_loaded() const { return loaded_; }  // whole ones
  uint32_t views() const { return total_; }
  bool complete() const { return total_ > 0 && loaded_ == total_; }

  // Of a complete plan.
  const tg_View& view(uint32_t index) const { return views_[index]; }
  uint32_t rays(uint32_t view) const { return rays_of(views_[view]); }
  RayTarget target(uint32_t view, uint32_t ray) const;

 private:
  // As driven: half the memory of angles, and the mirrors cannot do anything else.
  struct ListedRay {
    int16_t a_code, b_code;
  };
  tg_RefuseReason heads_agree(uint32_t plan_id, uint32_t total_views, uint32_t view, uint32_t ray,
                              Trouble* trouble) const;

  uint32_t plan_id_ = 0, total_ = 0, loaded_ = 0;
  uint32_t listed_ = 0;          // rays in the pool
  uint32_t listed_of_view_ = 0;  // of them, those of view `loaded_`, which is not whole yet
  tg_View views_[kMaxViews] = {};
  uint16_t first_listed_[kMaxViews] = {};
  ListedRay pool_[kMaxListedRays] = {};
};

// Null when the raster view can be measured, else what is wrong.
const char* view_error(const tg_View& view, const MachineConfig& config);

}  // namespace tetragauge
