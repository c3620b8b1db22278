// SPDX-License-Identifier: Apache-2.0
#include "firmware/scan/scan_plan.hpp"

namespace tetragauge {
namespace {

bool between(int64_t x, int64_t low, int64_t high) {
  return x >= low && x <= high;
}

bool mirrors_reach(int32_t first, int32_t step, uint32_t count, int32_t limit) {
  const int64_t last = first + int64_t{step} * (int64_t{count} - 1);
  return between(first, -limit, limit) && between(last, -limit, limit);
}

}  // namespace

const char* view_error(const tg_View& view, const MachineConfig& config) {
  const tg_StageConfig& stage = config.stage;
  if (!between(table_steps(config, view.table_udeg), stage.table.min_steps, stage.table.max_steps)) {
    return "table angle beyond the soft limits";
  }
  if (!between(slide_steps(config, view.slide_um), stage.slide.min_steps, stage.slide.max_steps)) {
    return "slide height beyond the soft limits";
  }
  if (view.columns == 0 || view.rows == 0 || uint64_t{view.columns} * view.rows > kMaxRaysPerView) {
    return "columns x rows must be 1 to 4,000,000";
  }
  if (view.samples < 2 || view.samples > kMaxSamples || view.samples % 2 != 0) {
    return "samples must be even, 2 to 4096";
  }
  if (!mirrors_reach(view.a_first_urad, view.a_step_urad, view.columns, config.galvo.limit_urad) ||
      !mirrors_reach(view.b_first_urad, view.b_step_urad, view.rows, config.galvo.limit_urad)) {
    return "raster window beyond the mirrors' limit";
  }
  return nullptr;
}

tg_RefuseReason ScanPlan::load(const tg_ScanLoad& chunk, const MachineConfig& config, Trouble* trouble) {
  if (chunk.plan_id == 0 || chunk.views_count == 0) {
    trouble->what = "plan id 0, or no views";
    return tg_RefuseReason_REFUSE_OUT_OF_RANGE;
  }
  if (chunk.total_views > kMaxViews) {
    trouble->what = "more views than HelloReply.max_views";
    return tg_RefuseReason_REFUSE_PLAN_TOO_LONG;
  }
  const bool starts = chunk.first_view == 0;
  const bool follows =
      chunk.plan_id == plan_id_ && chunk.total_views == total_ && chunk.first_view == loaded_;
  if ((!starts && !follows) || chunk.first_view + chunk.views_count > chunk.total_views) {
    trouble->what = "views must come in order, starting with first_view 0";
    return tg_RefuseReason_REFUSE_PLAN_ORDER;
  }
  for (uint32_t i = 0; i < chunk.views_count; ++i) {
    if (const char* error = view_error(chunk.views[i], config)) {
      *trouble = {error, chunk.first_view + i};
      return tg_RefuseReason_REFUSE_OUT_OF_RANGE;
    }
  }
  plan_id_ = chunk.plan_id;
  total_ = chunk.total_views;
  for (uint32_t i = 0; i < chunk.views_count; ++i) views_[chunk.first_view + i] = chunk.views[i];
  loaded_ = chunk.first_view + chunk.views_count;
  return tg_RefuseReason_REFUSE_NONE;
}

}  // namespace tetragauge
