// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller.hpp"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <random>

#include "firmware/test_host.hpp"

namespace tetragauge {
namespace {

tg_View small_view() {
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

TEST(Controller, ScansAPlateAndDeliversEveryRayOnce) {
  TestHost host;
  host.connect();
  host.home();
  const tg_View view = small_view();
  host.scan({view, view});
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 30)) << host.trouble();
  EXPECT_EQ(host.controller->state(), tg_State_STATE_READY);
  EXPECT_FALSE(host.end.aborted);
  ASSERT_EQ(host.beams.size(), 2u * 77u);
  for (size_t i = 0; i < host.beams.size(); ++i) {
    const BeamRecord& beam = host.beams[i];
    EXPECT_EQ(beam.view, i / 77);
    EXPECT_EQ(beam.ray, i % 77);
    EXPECT_EQ(beam.reason, 0u);
    // Rounding to codes: at most 1 code in 30,000 of each pair's difference, 10 mm / 30,000 on the detector,
    // 11 times that across the camera's ray, 1 / sin 22.5 times that along the beam.
    EXPECT_NEAR(beam.x_um, 0, 10'000.0 / 30'000 * 11 / 0.3827 + 1) << "the plate stands at x = 0";
    EXPECT_NEAR(beam.a_urad, target_of(view, beam.ray).a_urad, kUradPerMirrorCode / 2);
  }
  EXPECT_EQ(host.end.points, 154u);
  EXPECT_EQ(host.end.rejected, 0u);
  EXPECT_EQ(host.end.crc, host.crc());
}

}  // namespace
}  // namespace tetragauge
