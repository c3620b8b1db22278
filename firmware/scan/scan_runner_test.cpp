// SPDX-License-Identifier: Apache-2.0
#include "firmware/scan/scan_runner.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>
#include <random>
#include <vector>

#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

// With a converter of 12 bits.
struct CoarseBoard : FakeBoard {
  static constexpr int32_t kMirrorCodeStep = 16;
};

TEST(ScanRunner, ACoarseConverterIsAskedOnlyForWhatItCanDo) {
  CoarseBoard board;
  Supervisor<CoarseBoard> supervisor(board);
  AxisMover<CoarseBoard> table(board, Axis::kTable, Inputs::kTableHome),
      slide(board, Axis::kSlide, Inputs::kSlideHome);
  const auto ring = std::make_unique<StreamRing>();
  PsdSample burst[kBurstSamples];
  tg_MachineMessage outgoing = tg_MachineMessage_init_zero;
  ScanRunner<CoarseBoard> runner(board, supervisor, table, slide, *ring, burst, outgoing);
  for (int32_t urad = -170'000; urad <= 170'000; urad += 7) {
    runner.aim({urad, -urad});
    ASSERT_EQ(board.mirror_a % 16, 0);
    ASSERT_EQ(board.mirror_b, -board.mirror_a);
    ASSERT_EQ(runner.a_urad(), board.mirror_a * kUradPerMirrorCode) << "what is reported is what is driven";
    ASSERT_LE(std::abs(runner.a_urad() - urad), 16 * kUradPerMirrorCode / 2);
  }
}

using Codes = std::array<int16_t, 8>;

Codes codes_of(const PsdSample& sample) {
  Codes codes;
  static_assert(sizeof codes == sizeof sample);
  std::memcpy(codes.data(), &sample, sizeof sample);
  return codes;
}

class RawViews : public testing::Test {
 protected:
  void SetUp() override {
    host.connect();
    ASSERT_TRUE(host.home()) << host.trouble();
    // Every sample is a different one, and remembered with the mirrors' place.
    host.board.spoil_sample = [&](PsdSample& sample) {
      for (auto& camera : sample.camera) {
        for (int16_t* code : {&camera.x1, &camera.x2, &camera.y1, &camera.y2}) {
          *code = static_cast<int16_t>(*code + static_cast<int>(random() % 41) - 20);
        }
      }
      taken[{host.board.mirror_a, host.board.mirror_b}].push_back(codes_of(sample));
    };
    raw = small_view();
    raw.raw = true;
    raw.samples = 34;           // 17 + 34 + 17: items that are not full
    raw.a_first_urad -= 1'001;  // no ray in common with the other view
    raw.columns = 5;
    raw.rows = 3;
  }
  // The samples of each ray as they came, taken apart by the message's definition.
  std::map<uint32_t, std::vector<Codes>> received() const {
    std::map<uint32_t, std::vector<Codes>> rays;
    std::map<uint32_t, std::array<uint32_t, 3>> next;
    for (const TestHost::Raw& one : host.raw) {
      const tg_RawSamples& item = one.item;
      EXPECT_EQ(item.plan_id, host.plan_id());
      EXPECT_EQ(item.view, 0u);
      EXPECT_LE(one.beams_before, item.ray) << "before the batch its beam is in";
      EXPECT_EQ(item.codes_count % 8, 0u);
      EXPECT_EQ(item.first_sample, next[item.ray][item.phase]) << "in order, none lost";
      next[item.ray][item.phase] += item.codes_count / 8u;
      Codes last{};
      for (uint32_t i = 0; i < item.codes_count; i += 8) {
        for (size_t c = 0; c < 8; ++c) last[c] = static_cast<int16_t>(last[c] + item.codes[i + c]);
        rays[item.ray].push_back(last);
      }
    }
    for (const auto& [ray, count] : next) {
      EXPECT_EQ(count, (std::array<uint32_t, 3>{17, 34, 17})) << ray;
    }
    return rays;
  }
  void expect_all_samples() {
    ASSERT_TRUE(host.ended) << host.trouble();
    EXPECT_EQ(host.end.crc, host.crc());
    const auto rays = received();
    ASSERT_EQ(rays.size(), 15u);
    for (uint32_t ray = 0; ray < 15; ++ray) {
      const RayTarget target = target_of(raw, ray);
      const auto& all = taken[{static_cast<int16_t>(mirror_code(target.a_urad)),
                               static_cast<int16_t>(mirror_code(target.b_urad))}];
      // A ray that was interrupted and measured again has more: the last ones count.
      ASSERT_GE(all.size(), 68u);
      EXPECT_TRUE(rays.at(ray) == std::vector<Codes>(all.end() - 68, all.end())) << ray;
    }
  }

  TestHost host;
  tg_View raw = tg_View_init_zero;
  std::mt19937 random{12};
  std::map<std::pair<int16_t, int16_t>, std::vector<Codes>> taken;
};

TEST_F(RawViews, BringEverySampleBeforeItsBeam) {
  ASSERT_TRUE(host.scan({raw, small_view()}));
  host.run_until([&] { return host.ended; }, 30);
  expect_all_samples();
  EXPECT_EQ(host.beams.size(), 15 + kSmallViewRays);
}

TEST_F(RawViews, OfListedDirectionsMixWithRasters) {
  // A raster, then 60 single directions, raw, in two chunks, then a raster.
  const auto chunk = [](uint32_t view, std::vector<RayTarget> rays, uint32_t first, uint32_t total) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_measure_rays_tag;
    tg_MeasureRays& list = message.body.measure_rays;
    list.plan_id = 77;
    list.view = view;
    list.total_views = 3;
    list.table_udeg = 45'000'000;
    list.slide_um = 100'000;
    list.samples = 34;
    list.raw = true;
    list.first_ray = first;
    list.total_rays = total;
    RayTarget last;
    for (const RayTarget& ray : rays) {
      list.a_urad[list.a_urad_count++] = ray.a_urad - last.a_urad;
      list.b_urad[list.b_urad_count++] = ray.b_urad - last.b_urad;
      last = ray;
    }
    return message;
  };
  const auto raster = [](uint32_t view) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tg_HostMessage_scan_load_tag;
    message.body.scan_load.plan_id = 77;
    message.body.scan_load.first_view = view;
    message.body.scan_load.total_views = 3;
    message.body.scan_load.views_count = 1;
    message.body.scan_load.views[0] = small_view();
    return message;
  };
  std::vector<RayTarget> rays;
  for (int k = 0; k < 60; ++k) {
    rays.push_back(
        {static_cast<int32_t>(random() % 40'000) - 20'000, static_cast<int32_t>(random() % 40'000) - 20'000});
  }
  const auto taken_well = [&](const tg_HostMessage& message) {
    return host.ask(message).which_body == tg_MachineMessage_done_tag;
  };
  ASSERT_TRUE(taken_well(raster(0)));
  ASSERT_TRUE(taken_well(chunk(1, {rays.begin(), rays.begin() + 40}, 0, 60)));
  ASSERT_TRUE(taken_well(chunk(1, {rays.begin() + 40, rays.end()}, 40, 60)));
  ASSERT_TRUE(taken_well(raster(2)));
  ASSERT_EQ(host.controller->state(), tg_State_STATE_ARMED);
  host.begin_stream(77);
  ASSERT_TRUE(host.start());
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 60)) << host.trouble();
  ASSERT_EQ(host.beams.size(), 2 * kSmallViewRays + 60);
  EXPECT_EQ(host.end.crc, host.crc());
  for (uint32_t k = 0; k < 60; ++k) {
    const BeamRecord& beam = host.beams[kSmallViewRays + k];
    EXPECT_EQ(beam.view, 1u);
    EXPECT_EQ(beam.ray, k);
    EXPECT_EQ(beam.reason, 0u);
    EXPECT_LE(std::abs(beam.a_urad - rays[k].a_urad), kUradPerMirrorCode / 2);
    EXPECT_LE(std::abs(beam.b_urad - rays[k].b_urad), kUradPerMirrorCode / 2);
  }
  EXPECT_EQ(host.raw.size(), 60u * (2 + 3 + 2)) << "17, 34 and 17 samples in items of 16";
}

TEST_F(RawViews, LoseNothingWhenTheRingIsFull) {
  // 15 rays are 90 items; the ring holds 32 and the host stays away for ten seconds.
  host.credits = false;
  ASSERT_TRUE(host.scan({raw}));
  host.run(10);
  const uint32_t times = host.board.times_laser_on;
  host.run(10);
  EXPECT_EQ(host.board.times_laser_on, times) << "nothing is measured with the ring full";
  EXPECT_LT(times, 15u);
  EXPECT_FALSE(host.board.laser);
  host.credits = true;
  host.credit_window = 2;
  host.send_credit();
  host.run_until([&] { return host.ended; }, 30);
  expect_all_samples();
}

TEST_F(RawViews, AreMeasuredAgainWholeAfterAPause) {
  ASSERT_TRUE(host.scan({raw}));
  int events = 0;
  while (!host.ended && events < 200'000) {
    host.run_until([&] { return ++events % 17 == 0 || host.ended; }, 1);
    if (host.controller->state() != tg_State_STATE_SCANNING) continue;
    ASSERT_TRUE(host.accepted(tg_HostMessage_scan_pause_tag));
    ASSERT_TRUE(host.accepted(tg_HostMessage_scan_resume_tag));
  }
  expect_all_samples();
}

}  // namespace
}  // namespace tetragauge
