// SPDX-License-Identifier: Apache-2.0
#include "firmware/scan/scan_plan.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

TEST(ScanPlan, WalksBoustrophedon) {
  tg_View view = small_view();
  view.columns = 3;
  view.rows = 3;
  const int32_t a = view.a_first_urad, b = view.b_first_urad, da = view.a_step_urad, db = view.b_step_urad;
  const int32_t expected[9][2] = {
      {a, b},      {a + da, b},     {a + 2 * da, b},      {a + 2 * da, b + db},    {a + da, b + db},
      {a, b + db}, {a, b + 2 * db}, {a + da, b + 2 * db}, {a + 2 * da, b + 2 * db}};
  for (uint32_t ray = 0; ray < 9; ++ray) {
    EXPECT_EQ(target_of(view, ray).a_urad, expected[ray][0]);
    EXPECT_EQ(target_of(view, ray).b_urad, expected[ray][1]);
  }
}

TEST(ScanPlan, RefusesViewsTheMachineCannotDo) {
  const MachineConfig config = nominal_config();
  const auto error_after = [&](void (*spoil)(tg_View&)) {
    tg_View view = small_view();
    spoil(view);
    const char* error = view_error(view, config);
    return std::string(error ? error : "");
  };
  EXPECT_EQ(error_after([](tg_View&) {}), "");
  EXPECT_EQ(error_after([](tg_View& v) { v.slide_um = 301'000; }), "");
  EXPECT_EQ(error_after([](tg_View& v) { v.slide_um = 301'010; }), "slide height beyond the soft limits");
  EXPECT_EQ(error_after([](tg_View& v) { v.table_udeg = -180'010'000; }),
            "table angle beyond the soft limits");
  EXPECT_EQ(error_after([](tg_View& v) { v.rows = 0; }), "columns x rows must be 1 to 4,000,000");
  EXPECT_EQ(error_after([](tg_View& v) { v.rows = v.columns = 100'000; }),
            "columns x rows must be 1 to 4,000,000");
  EXPECT_EQ(error_after([](tg_View& v) { v.samples = 5; }), "samples must be even, 2 to 4096");
  EXPECT_EQ(error_after([](tg_View& v) { v.raw = true, v.samples = 128; }), "");
  EXPECT_EQ(error_after([](tg_View& v) { v.raw = true, v.samples = 130; }),
            "raw views must have 2 to 128 samples");
  EXPECT_EQ(error_after([](tg_View& v) { v.a_first_urad = 174'533 - 29'000; }),
            "raster window beyond the mirrors' limit");
  EXPECT_EQ(error_after([](tg_View& v) { v.columns = 400'000, v.rows = 1, v.a_step_urad = 2'000'000'000; }),
            "raster window beyond the mirrors' limit")
      << "beyond 32 bits";
}

TEST(ScanPlan, TakesChunksInOrderOnly) {
  const MachineConfig config = nominal_config();
  const auto plan = std::make_unique<ScanPlan>();
  ScanPlan::Trouble trouble;
  const auto chunk = [](uint32_t id, uint32_t first, uint32_t count, uint32_t total) {
    tg_ScanLoad load = tg_ScanLoad_init_zero;
    load.plan_id = id;
    load.first_view = first;
    load.total_views = total;
    load.views_count = static_cast<pb_size_t>(count);
    for (uint32_t i = 0; i < count; ++i) {
      load.views[i] = small_view();
      load.views[i].slide_um = static_cast<int32_t>(1000 * (first + i));
    }
    return load;
  };
  const auto load = [&](const tg_ScanLoad& one) { return plan->load(one, config, &trouble); };
  EXPECT_EQ(load(chunk(1, 8, 2, 10)), tg_RefuseReason_REFUSE_PLAN_ORDER);
  EXPECT_EQ(load(chunk(1, 0, 8, 10)), tg_RefuseReason_REFUSE_NONE);
  EXPECT_FALSE(plan->complete());
  EXPECT_EQ(load(chunk(2, 8, 2, 10)), tg_RefuseReason_REFUSE_PLAN_ORDER) << "of another plan";
  EXPECT_EQ(load(chunk(1, 8, 3, 10)), tg_RefuseReason_REFUSE_PLAN_ORDER) << "more than announced";
  EXPECT_EQ(load(chunk(1, 8, 2, 10)), tg_RefuseReason_REFUSE_NONE);
  EXPECT_TRUE(plan->complete());
  for (uint32_t i = 0; i < 10; ++i) EXPECT_EQ(plan->view(i).slide_um, static_cast<int32_t>(1000 * i));
  EXPECT_EQ(load(chunk(0, 0, 1, 1)), tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_EQ(load(chunk(3, 0, 8, kMaxViews + 1)), tg_RefuseReason_REFUSE_PLAN_TOO_LONG);
  tg_ScanLoad bad = chunk(4, 0, 5, 5);
  bad.views[3].slide_um = 340'000;
  EXPECT_EQ(load(bad), tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_EQ(trouble.view, 3u);
  EXPECT_STREQ(trouble.what, "slide height beyond the soft limits");
  EXPECT_TRUE(plan->complete()) << "a refused chunk changes nothing";
  EXPECT_EQ(plan->plan_id(), 1u);
}

// Rays first .. first + count - 1 of a listed view, as MeasureRays carries them.
tg_MeasureRays rays_chunk(uint32_t id, uint32_t view, uint32_t views, const std::vector<RayTarget>& rays,
                          uint32_t first, uint32_t count) {
  tg_MeasureRays chunk = tg_MeasureRays_init_zero;
  chunk.plan_id = id;
  chunk.view = view;
  chunk.total_views = views;
  chunk.table_udeg = 20'000'000;
  chunk.slide_um = 50'000;
  chunk.samples = 8;
  chunk.first_ray = first;
  chunk.total_rays = static_cast<uint32_t>(rays.size());
  RayTarget last;
  for (uint32_t i = first; i < first + count; ++i) {
    chunk.a_urad[chunk.a_urad_count++] = rays[i].a_urad - last.a_urad;
    chunk.b_urad[chunk.b_urad_count++] = rays[i].b_urad - last.b_urad;
    last = rays[i];
  }
  return chunk;
}

std::vector<RayTarget> scattered(size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<RayTarget> rays(count);
  for (RayTarget& ray : rays) {
    ray = {static_cast<int32_t>(random() % 349'000) - 174'500,
           static_cast<int32_t>(random() % 349'000) - 174'500};
  }
  return rays;
}

tg_ScanLoad raster_chunk(uint32_t id, uint32_t first, uint32_t count, uint32_t total) {
  tg_ScanLoad load = tg_ScanLoad_init_zero;
  load.plan_id = id;
  load.first_view = first;
  load.total_views = total;
  load.views_count = static_cast<pb_size_t>(count);
  for (uint32_t i = 0; i < count; ++i) load.views[i] = small_view();
  return load;
}

class ListedRays : public testing::Test {
 protected:
  template <class Chunk>
  tg_RefuseReason load(const Chunk& chunk) {
    return plan->load(chunk, config, &trouble);
  }
  const MachineConfig config = nominal_config();
  const std::unique_ptr<ScanPlan> plan = std::make_unique<ScanPlan>();
  ScanPlan::Trouble trouble;
};

TEST_F(ListedRays, MixWithRastersInOnePlan) {
  const auto first = scattered(100, 1), second = scattered(7, 2);
  // Views: raster, listed (48 + 48 + 4 rays), raster, raster, listed.
  EXPECT_EQ(load(raster_chunk(9, 0, 1, 5)), tg_RefuseReason_REFUSE_NONE);
  EXPECT_EQ(load(rays_chunk(9, 1, 5, first, 0, 48)), tg_RefuseReason_REFUSE_NONE);
  EXPECT_EQ(load(rays_chunk(9, 1, 5, first, 48, 48)), tg_RefuseReason_REFUSE_NONE);
  EXPECT_EQ(plan->views_loaded(), 1u) << "the listed view is not whole yet";
  EXPECT_EQ(load(rays_chunk(9, 1, 5, first, 96, 4)), tg_RefuseReason_REFUSE_NONE);
  EXPECT_EQ(load(raster_chunk(9, 2, 2, 5)), tg_RefuseReason_REFUSE_NONE);
  EXPECT_FALSE(plan->complete());
  EXPECT_EQ(load(rays_chunk(9, 4, 5, second, 0, 7)), tg_RefuseReason_REFUSE_NONE);
  ASSERT_TRUE(plan->complete());
  ASSERT_EQ(plan->views(), 5u);
  EXPECT_EQ(plan->rays(0), kSmallViewRays);
  EXPECT_EQ(plan->rays(1), 100u);
  EXPECT_EQ(plan->rays(4), 7u);
  EXPECT_EQ(plan->view(1).table_udeg, 20'000'000);
  EXPECT_EQ(plan->view(1).samples, 8u);
  for (uint32_t ray = 0; ray < kSmallViewRays; ++ray) {
    EXPECT_EQ(plan->target(2, ray).a_urad, target_of(small_view(), ray).a_urad);
    EXPECT_EQ(plan->target(2, ray).b_urad, target_of(small_view(), ray).b_urad);
  }
  for (uint32_t ray = 0; ray < 107; ++ray) {
    const RayTarget& meant = ray < 100 ? first[ray] : second[ray - 100];
    const RayTarget is = ray < 100 ? plan->target(1, ray) : plan->target(4, ray - 100);
    // The converter's nearest step.
    EXPECT_EQ(is.a_urad % kUradPerMirrorCode, 0);
    EXPECT_LE(std::abs(is.a_urad - meant.a_urad), kUradPerMirrorCode / 2);
    EXPECT_LE(std::abs(is.b_urad - meant.b_urad), kUradPerMirrorCode / 2);
  }
}

TEST_F(ListedRays, AreTakenInOrderOnlyAndARefusedChunkChangesNothing) {
  const auto rays = scattered(60, 3);
  EXPECT_EQ(load(rays_chunk(1, 0, 2, rays, 48, 12)), tg_RefuseReason_REFUSE_PLAN_ORDER) << "no first chunk";
  EXPECT_EQ(load(rays_chunk(1, 1, 2, rays, 0, 48)), tg_RefuseReason_REFUSE_PLAN_ORDER) << "no first view";
  EXPECT_EQ(load(rays_chunk(0, 0, 2, rays, 0, 48)), tg_RefuseReason_REFUSE_OUT_OF_RANGE) << "plan id 0";
  ASSERT_EQ(load(rays_chunk(1, 0, 2, rays, 0, 40)), tg_RefuseReason_REFUSE_NONE);

  EXPECT_EQ(load(rays_chunk(2, 0, 2, rays, 40, 20)), tg_RefuseReason_REFUSE_PLAN_ORDER) << "of another plan";
  EXPECT_EQ(load(rays_chunk(1, 0, 3, rays, 40, 20)), tg_RefuseReason_REFUSE_PLAN_ORDER) << "of a longer plan";
  EXPECT_EQ(load(rays_chunk(1, 0, 2, rays, 41, 19)), tg_RefuseReason_REFUSE_PLAN_ORDER) << "a ray is missing";
  EXPECT_EQ(load(raster_chunk(1, 1, 1, 2)), tg_RefuseReason_REFUSE_PLAN_ORDER) << "the view is not whole";
  EXPECT_EQ(load(rays_chunk(1, 1, 2, rays, 0, 20)), tg_RefuseReason_REFUSE_PLAN_ORDER)
      << "the view is not whole";
  const auto spoilt = [&](void (*spoil)(tg_MeasureRays&)) {
    tg_MeasureRays chunk = rays_chunk(1, 0, 2, rays, 40, 20);
    spoil(chunk);
    return load(chunk);
  };
  using C = tg_MeasureRays;
  EXPECT_EQ(spoilt([](C& c) { c.slide_um += 10; }), tg_RefuseReason_REFUSE_PLAN_ORDER);
  EXPECT_EQ(spoilt([](C& c) { c.table_udeg += 10; }), tg_RefuseReason_REFUSE_PLAN_ORDER);
  EXPECT_EQ(spoilt([](C& c) { c.samples = 10; }), tg_RefuseReason_REFUSE_PLAN_ORDER);
  EXPECT_EQ(spoilt([](C& c) { c.raw = true; }), tg_RefuseReason_REFUSE_PLAN_ORDER);
  EXPECT_EQ(spoilt([](C& c) { c.total_rays = 61; }), tg_RefuseReason_REFUSE_PLAN_ORDER);
  EXPECT_EQ(spoilt([](C& c) { c.total_rays = 59; }), tg_RefuseReason_REFUSE_PLAN_ORDER);
  EXPECT_EQ(spoilt([](C& c) { c.b_urad_count = 19; }), tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_EQ(spoilt([](C& c) { c.a_urad_count = c.b_urad_count = 0; }), tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_EQ(spoilt([](C& c) { c.b_urad[19] += 400'000; }), tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_EQ(spoilt([](C& c) { c.a_urad[0] = c.a_urad[1] = 2'000'000'000; }),
            tg_RefuseReason_REFUSE_OUT_OF_RANGE)
      << "a sum beyond 32 bits wraps, and is beyond the limit before it comes back";
  EXPECT_STREQ(trouble.what, "a direction beyond the mirrors' limit");

  // After all that the second half still fits.
  ASSERT_EQ(load(rays_chunk(1, 0, 2, rays, 40, 20)), tg_RefuseReason_REFUSE_NONE);
  EXPECT_EQ(plan->views_loaded(), 1u);
  ASSERT_EQ(load(raster_chunk(1, 1, 1, 2)), tg_RefuseReason_REFUSE_NONE);
  ASSERT_TRUE(plan->complete());
  EXPECT_EQ(load(rays_chunk(1, 2, 2, rays, 0, 20)), tg_RefuseReason_REFUSE_PLAN_ORDER)
      << "beyond the last view";

  tg_MeasureRays off = rays_chunk(5, 0, 1, rays, 0, 20);
  off.slide_um = 340'000;
  EXPECT_EQ(load(off), tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_STREQ(trouble.what, "slide height beyond the soft limits");
  EXPECT_TRUE(plan->complete());
  EXPECT_EQ(plan->plan_id(), 1u);
}

TEST_F(ListedRays, ShareAPool) {
  const auto rays = scattered(kMaxListedRays, 4);
  const auto load_all = [&](uint32_t id) {
    for (uint32_t first = 0; first < rays.size(); first += 48) {
      const auto count = std::min<uint32_t>(48, static_cast<uint32_t>(rays.size()) - first);
      const tg_RefuseReason reason = load(rays_chunk(id, 0, 2, rays, first, count));
      if (reason != tg_RefuseReason_REFUSE_NONE) return reason;
    }
    return tg_RefuseReason_REFUSE_NONE;
  };
  ASSERT_EQ(load_all(1), tg_RefuseReason_REFUSE_NONE);
  EXPECT_EQ(load(rays_chunk(1, 1, 2, {RayTarget{}}, 0, 1)), tg_RefuseReason_REFUSE_PLAN_TOO_LONG);
  ASSERT_EQ(load(raster_chunk(1, 1, 1, 2)), tg_RefuseReason_REFUSE_NONE) << "rasters need none of it";
  EXPECT_TRUE(plan->complete());
  ASSERT_EQ(load_all(2), tg_RefuseReason_REFUSE_NONE) << "a new plan has the whole pool";
  for (uint32_t ray = 0; ray < kMaxListedRays; ++ray) {
    ASSERT_LE(std::abs(plan->target(0, ray).a_urad - rays[ray].a_urad), kUradPerMirrorCode / 2);
  }
  const auto too_many = scattered(kMaxListedRays + 1, 5);
  EXPECT_EQ(load(rays_chunk(3, 0, 1, too_many, 0, 48)), tg_RefuseReason_REFUSE_PLAN_TOO_LONG);
}

}  // namespace
}  // namespace tetragauge
