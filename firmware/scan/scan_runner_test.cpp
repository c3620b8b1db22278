// SPDX-License-Identifier: Apache-2.0
#include "firmware/scan/scan_runner.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>
#include <random>

#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

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
