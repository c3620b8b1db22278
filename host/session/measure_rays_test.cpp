// SPDX-License-Identifier: GPL-3.0-or-later
// Single directions against the raster they were taken from: the emulated machine's noise is a function of
// place, so the same beams must give the same points.
#include "host/session/measure_rays.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "host/session/emulated_session.hpp"
#include "host/session/prepare_machine.hpp"

namespace tetragauge {
namespace {

constexpr uint32_t kSamples = 16;
constexpr double kWireUnit_mm = 1e-3;   // of coordinates
constexpr double kWireSigma_mm = 1e-4;  // of sigmas
constexpr double kWireIntensity = 1e-3;
constexpr double kSlack = 1.001;  // float in the scan

struct Bench {
  EmulatedSession session;
  HeadGeometry head;
};

Result<Bench> start_bench(const std::filesystem::path& part) {
  auto session = start_session({.part = part});
  if (!session) return session.error();
  const auto config = read_head_config(*session->link);
  if (!config) return config.error();
  return Bench{std::move(*session), head_geometry(config->galvo, config->stage)};
}

std::vector<SingleRay> rays_of_raster(const HeadGeometry& head, const PlannedView& planned) {
  const auto view = lay_raster(head, planned);
  EXPECT_TRUE(view);
  std::vector<SingleRay> rays;
  // As View in machine.proto says: odd rows backwards.
  for (uint32_t row = 0; row < view->rows; ++row) {
    for (uint32_t k = 0; k < view->columns; ++k) {
      const uint32_t column = row % 2 == 0 ? k : view->columns - 1 - k;
      rays.push_back({planned.table_deg, planned.slide_mm,
                      view->a_first_urad + static_cast<int32_t>(column) * view->a_step_urad,
                      view->b_first_urad + static_cast<int32_t>(row) * view->b_step_urad});
    }
  }
  return rays;
}

// Ray by ray of all views in turn, so that the session has to sort them by place.
std::vector<SingleRay> interleaved(const std::vector<std::vector<SingleRay>>& views) {
  std::vector<SingleRay> all;
  for (size_t k = 0; k < views[0].size(); ++k)
    for (const auto& view : views)
      if (k < view.size()) all.push_back(view[k]);
  return all;
}

TEST(MeasureRays, GiveThePointsOfTheRasterTheyWereTakenFrom) {
  auto bench = start_bench(box_file());
  ASSERT_TRUE(bench) << bench.error().message;
  Link& link = *bench->session.link;
  const ScanPlan plan = plan_all_round(4, kSamples);
  std::vector<std::vector<SingleRay>> views;
  for (const PlannedView& view : plan.views) views.push_back(rays_of_raster(bench->head, view));
  const std::vector<SingleRay> rays = interleaved(views);
  ASSERT_GT(rays.size(), link.machine().max_listed_rays) << "more than one run";

  const auto raster = run_scan(link, plan, {.keep_table = true});
  ASSERT_TRUE(raster) << raster.error().message;
  const auto single = measure_rays(link, rays, kSamples, {.keep_table = true});
  ASSERT_TRUE(single) << single.error().message;

  EXPECT_EQ(single->counts.beams, rays.size());
  EXPECT_EQ(single->counts.timed_beams, rays.size());
  EXPECT_GT(single->counts.machine_time_s, 0);
  EXPECT_EQ(single->counts.rejected, raster->counts.rejected);
  const Scan &a = raster->scan, &b = single->scan;
  ASSERT_GT(a.size(), 500u);
  ASSERT_EQ(b.size(), a.size());
  EXPECT_EQ(b.view, a.view);
  EXPECT_EQ(b.flags, a.flags);
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_LT((b.ray_origins[i] - a.ray_origins[i]).norm(), 1e-9) << i;
    const PlannedView& view = plan.views[a.view[i]];
    const Vec3 apart =
        T_machine_part(bench->head, view.table_deg, view.slide_mm).R * (b.points[i] - a.points[i]);
    ASSERT_LE(apart.cwiseAbs().maxCoeff(), kSlack * kWireUnit_mm) << i;
    ASSERT_NEAR(b.sigma_mm[i], a.sigma_mm[i], kSlack * kWireSigma_mm) << i;
    ASSERT_NEAR(b.intensity[i], a.intensity[i], kSlack * kWireIntensity) << i;
  }
  ASSERT_GT(a.rejected.size(), 100u);
  ASSERT_EQ(b.rejected.size(), a.rejected.size());
  for (size_t i = 0; i < a.rejected.size(); ++i) {
    EXPECT_EQ(b.rejected[i].reason, a.rejected[i].reason) << i;
    EXPECT_EQ(b.rejected[i].view, a.rejected[i].view) << i;
    EXPECT_LT((b.rejected[i].origin - a.rejected[i].origin).norm(), 1e-9) << i;
    EXPECT_LT((b.rejected[i].direction - a.rejected[i].direction).norm(), 1e-12) << i;
  }
}

TEST(MeasureRays, OfAnEmptyListIsAnEmptyScan) {
  auto bench = start_bench(box_file());
  ASSERT_TRUE(bench) << bench.error().message;
  const auto measured = measure_rays(*bench->session.link, {});
  ASSERT_TRUE(measured) << measured.error().message;
  EXPECT_EQ(measured->scan.size(), 0u);
  EXPECT_EQ(measured->counts.beams, 0u);
  EXPECT_FALSE(measured->scan.header.machine_id.empty());
}

TEST(MeasureRays, WhatCannotBeReachedIsRefusedByNumberAndTheMachineIsAsBefore) {
  auto bench = start_bench(box_file());
  ASSERT_TRUE(bench) << bench.error().message;
  Link& link = *bench->session.link;
  const SingleRay good{.table_deg = 10, .slide_mm = 175, .a_urad = 1000, .b_urad = -1000};
  const auto refused = [&](const SingleRay& bad) {
    const std::vector<SingleRay> rays = {good, good, bad, good};
    const auto measured = measure_rays(link, rays, kSamples);
    EXPECT_FALSE(measured);
    return measured ? Error{} : measured.error();
  };
  SingleRay aside = good;
  aside.b_urad = bench->head.mirror_limit_urad + 1;
  const Error mirror = refused(aside);
  EXPECT_EQ(mirror.kind, ErrorKind::bad_input);
  for (const char* word : {"direction 3", "mirror b", std::to_string(aside.b_urad).c_str(), "leave it out"})
    EXPECT_NE(mirror.message.find(word), std::string::npos) << mirror.message;
  SingleRay nowhere = good;
  nowhere.slide_mm = std::numeric_limits<double>::quiet_NaN();
  const Error stage = refused(nowhere);
  EXPECT_EQ(stage.kind, ErrorKind::bad_input);
  EXPECT_NE(stage.message.find("slide_mm"), std::string::npos) << stage.message;
  SingleRay too_high = good;
  too_high.slide_mm = 1000;
  const Error slide = refused(too_high);
  EXPECT_EQ(slide.kind, ErrorKind::machine);
  EXPECT_NE(slide.message.find("slide height beyond the soft limits"), std::string::npos) << slide.message;

  const auto measured = measure_rays(link, std::vector<SingleRay>{good}, kSamples);
  ASSERT_TRUE(measured) << measured.error().message;
  EXPECT_EQ(measured->scan.size(), 1u);
}

}  // namespace
}  // namespace tetragauge
