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

// What rasters and lists have in common.
const char* place_error(const tg_View& view, const MachineConfig& config) {
  const tg_StageConfig& stage = config.stage;
  if (!between(table_steps(config, view.table_udeg), stage.table.min_steps, stage.table.max_steps)) {
    return "table angle beyond the soft limits";
  }
  if (!between(slide_steps(config, view.slide_um), stage.slide.min_steps, stage.slide.max_steps)) {
    return "slide height beyond the soft limits";
  }
  if (view.samples < 2 || view.samples > kMaxSamples || view.samples % 2 != 0) {
    return "samples must be even, 2 to 4096";
  }
  if (view.raw && view.samples > kMaxRawSamples) return "raw views must have 2 to 128 samples";
  return nullptr;
}

// The view a listed chunk belongs to.
tg_View view_of(const tg_MeasureRays& chunk) {
  tg_View view = tg_View_init_zero;
  view.table_udeg = chunk.table_udeg;
  view.slide_um = chunk.slide_um;
  view.columns = chunk.total_rays;
  view.samples = chunk.samples;
  view.raw = chunk.raw;
  return view;
}

bool same_view(const tg_View& x, const tg_View& y) {
  return x.table_udeg == y.table_udeg && x.slide_um == y.slide_um && x.columns == y.columns &&
         x.rows == y.rows && x.samples == y.samples && x.raw == y.raw;
}

// The entries of two arrays of differences, summed up; sums wrap as the differences did.
struct Walk {
  uint32_t a = 0, b = 0;
  RayTarget next(int32_t da, int32_t db) {
    a += static_cast<uint32_t>(da);
    b += static_cast<uint32_t>(db);
    return {static_cast<int32_t>(a), static_cast<int32_t>(b)};
  }
};

}  // namespace

const char* view_error(const tg_View& view, const MachineConfig& config) {
  if (const char* error = place_error(view, config)) return error;
  if (view.columns == 0 || view.rows == 0 || uint64_t{view.columns} * view.rows > kMaxRaysPerView) {
    return "columns x rows must be 1 to 4,000,000";
  }
  if (!mirrors_reach(view.a_first_urad, view.a_step_urad, view.columns, config.galvo.limit_urad) ||
      !mirrors_reach(view.b_first_urad, view.b_step_urad, view.rows, config.galvo.limit_urad)) {
    return "raster window beyond the mirrors' limit";
  }
  return nullptr;
}

// Whether a chunk that begins with this view and ray may come now.
tg_RefuseReason ScanPlan::heads_agree(uint32_t plan_id, uint32_t total_views, uint32_t view, uint32_t ray,
                                      Trouble* trouble) const {
  if (plan_id == 0) {
    *trouble = {"plan id 0", view};
    return tg_RefuseReason_REFUSE_OUT_OF_RANGE;
  }
  if (total_views > kMaxViews) {
    *trouble = {"more views than HelloReply.max_views", view};
    return tg_RefuseReason_REFUSE_PLAN_TOO_LONG;
  }
  const bool starts = view == 0 && ray == 0;
  const bool follows =
      plan_id == plan_id_ && total_views == total_ && view == loaded_ && ray == listed_of_view_;
  if (view >= total_views || (!starts && !follows)) {
    *trouble = {"chunks must follow each other in views and rays, starting with the first of view 0", view};
    return tg_RefuseReason_REFUSE_PLAN_ORDER;
  }
  return tg_RefuseReason_REFUSE_NONE;
}

tg_RefuseReason ScanPlan::load(const tg_ScanLoad& chunk, const MachineConfig& config, Trouble* trouble) {
  if (const tg_RefuseReason reason =
          heads_agree(chunk.plan_id, chunk.total_views, chunk.first_view, 0, trouble)) {
    return reason;
  }
  if (chunk.views_count == 0) {
    *trouble = {"a chunk without views", chunk.first_view};
    return tg_RefuseReason_REFUSE_OUT_OF_RANGE;
  }
  if (chunk.views_count > chunk.total_views - chunk.first_view) {
    *trouble = {"more views than announced", chunk.total_views};
    return tg_RefuseReason_REFUSE_PLAN_ORDER;
  }
  for (uint32_t i = 0; i < chunk.views_count; ++i) {
    if (const char* error = view_error(chunk.views[i], config)) {
      *trouble = {error, chunk.first_view + i};
      return tg_RefuseReason_REFUSE_OUT_OF_RANGE;
    }
  }
  if (chunk.first_view == 0) forget();
  plan_id_ = chunk.plan_id;
  total_ = chunk.total_views;
  for (uint32_t i = 0; i < chunk.views_count; ++i) views_[chunk.first_view + i] = chunk.views[i];
  loaded_ = chunk.first_view + chunk.views_count;
  return tg_RefuseReason_REFUSE_NONE;
}

tg_RefuseReason ScanPlan::load(const tg_MeasureRays& chunk, const MachineConfig& config, Trouble* trouble) {
  if (const tg_RefuseReason reason =
          heads_agree(chunk.plan_id, chunk.total_views, chunk.view, chunk.first_ray, trouble)) {
    return reason;
  }
  const tg_View view = view_of(chunk);
  const uint32_t count = chunk.a_urad_count;
  const bool starts_plan = chunk.view == 0 && chunk.first_ray == 0;
  const bool starts_view = chunk.first_ray == 0;
  const auto refused = [&](tg_RefuseReason reason, const char* what) {
    *trouble = {what, chunk.view};
    return reason;
  };
  if (count == 0 || chunk.b_urad_count != count) {
    return refused(tg_RefuseReason_REFUSE_OUT_OF_RANGE,
                   "a_urad and b_urad must hold the same number of rays, not none");
  }
  if (chunk.first_ray >= chunk.total_rays || count > chunk.total_rays - chunk.first_ray) {
    return refused(tg_RefuseReason_REFUSE_PLAN_ORDER, "more rays than the view's total_rays");
  }
  if (!starts_view && !same_view(view, views_[chunk.view])) {
    return refused(tg_RefuseReason_REFUSE_PLAN_ORDER,
                   "place, samples or total_rays differ from the view's first chunk");
  }
  const uint32_t before = starts_plan ? 0 : listed_;
  if (starts_view && chunk.total_rays > kMaxListedRays - before) {
    return refused(tg_RefuseReason_REFUSE_PLAN_TOO_LONG,
                   "more single directions than HelloReply.max_listed_rays");
  }
  if (const char* error = place_error(view, config))
    return refused(tg_RefuseReason_REFUSE_OUT_OF_RANGE, error);
  Walk checked;
  for (uint32_t i = 0; i < count; ++i) {
    const RayTarget ray = checked.next(chunk.a_urad[i], chunk.b_urad[i]);
    const int32_t limit = config.galvo.limit_urad;
    if (!between(ray.a_urad, -limit, limit) || !between(ray.b_urad, -limit, limit)) {
      return refused(tg_RefuseReason_REFUSE_OUT_OF_RANGE, "a direction beyond the mirrors' limit");
    }
  }

  if (starts_plan) forget();
  plan_id_ = chunk.plan_id;
  total_ = chunk.total_views;
  if (starts_view) {
    views_[chunk.view] = view;
    first_listed_[chunk.view] = static_cast<uint16_t>(listed_);
  }
  Walk walk;
  for (uint32_t i = 0; i < count; ++i) {
    const RayTarget ray = walk.next(chunk.a_urad[i], chunk.b_urad[i]);
    pool_[listed_++] = {static_cast<int16_t>(mirror_code(ray.a_urad)),
                        static_cast<int16_t>(mirror_code(ray.b_urad))};
  }
  listed_of_view_ += count;
  if (listed_of_view_ == chunk.total_rays) {
    ++loaded_;
    listed_of_view_ = 0;
  }
  return tg_RefuseReason_REFUSE_NONE;
}

RayTarget ScanPlan::target(uint32_t view, uint32_t ray) const {
  if (!is_listed(views_[view])) return target_of(views_[view], ray);
  const ListedRay& listed = pool_[first_listed_[view] + ray];
  return {listed.a_code * kUradPerMirrorCode, listed.b_code * kUradPerMirrorCode};
}

}  // namespace tetragauge
