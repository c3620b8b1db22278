// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller.hpp"

#include <gtest/gtest.h>

#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

class ControllerTest : public testing::Test {
 protected:
  void SetUp() override {
    host.connect();
    ASSERT_TRUE(host.home()) << host.trouble();
  }
  // Every ray once, in order, all of them points on the plate; sums as the machine says.
  void expect_whole_scan(uint32_t views) {
    ASSERT_TRUE(host.ended) << host.trouble();
    EXPECT_FALSE(host.end.aborted);
    ASSERT_EQ(host.beams.size(), views * kSmallViewRays);
    for (uint32_t i = 0; i < host.beams.size(); ++i) {
      const BeamRecord& beam = host.beams[i];
      ASSERT_EQ(beam.view, i / kSmallViewRays);
      ASSERT_EQ(beam.ray, i % kSmallViewRays);
      EXPECT_EQ(beam.reason, 0u);
      EXPECT_EQ(beam.flags, 0u);
      // Rounding to codes: at most 1 code in 30,000 of each pair's difference, 10 mm / 30,000 on the
      // detector, 11 times that across the camera's ray, 1 / sin 22.5 times that along the beam.
      EXPECT_NEAR(beam.x_um, 0, 10'000.0 / 30'000 * 11 / 0.3827 + 1) << "the plate stands at x = 0";
      EXPECT_NEAR(beam.a_urad, target_of(small_view(), beam.ray).a_urad, kUradPerMirrorCode / 2);
      EXPECT_NEAR(beam.b_urad, target_of(small_view(), beam.ray).b_urad, kUradPerMirrorCode / 2);
    }
    EXPECT_EQ(host.end.points, host.beams.size());
    EXPECT_EQ(host.end.rejected, 0u);
    EXPECT_EQ(host.end.crc, host.crc());
  }
  tg_State state() const { return host.controller->state(); }

  TestHost host;
};

TEST_F(ControllerTest, ScansAPlateAndDeliversEveryRayOnce) {
  tg_View turned = small_view();
  turned.table_udeg = -60'000'000;
  turned.slide_um = 12'345;
  ASSERT_TRUE(host.scan({small_view(), turned}));
  host.run_until([&] { return host.ended; }, 30);
  expect_whole_scan(2);
  EXPECT_EQ(state(), tg_State_STATE_READY);
  EXPECT_FALSE(host.board.laser);
  EXPECT_EQ(host.board.times_laser_on, 2 * kSmallViewRays);
  // The stage stands where the second view wanted it, in whole steps (0.01 degrees, 5 um) from the switches'
  // true edges (nominal: -18,100 and -400 steps).
  EXPECT_EQ(host.board.position[0] - host.board.table_home, -6'000 + 18'100);
  EXPECT_EQ(host.board.position[1] - host.board.slide_home, 2'469 + 400);
}

TEST_F(ControllerTest, ReportsWhereItIs) {
  ASSERT_TRUE(host.scan({small_view()}));
  host.run_until([&] { return host.ended; }, 30);
  const tg_Status status = host.ask(tg_HostMessage_get_status_tag).body.status;
  EXPECT_EQ(status.state, tg_State_STATE_READY);
  EXPECT_TRUE(status.homed);
  EXPECT_EQ(status.table_udeg, 30'000'000);
  EXPECT_EQ(status.slide_um, 100'000);
  EXPECT_EQ(status.stream_next, host.items);
  EXPECT_EQ(status.stream_acked, host.items);
  EXPECT_EQ(status.bad_frames, 0u);
  EXPECT_EQ(status.home_spread_slide_um, 0u);
}

TEST_F(ControllerTest, SilentHostPausesAndResumedScanIsTheSame) {
  tg_View slow = small_view();
  slow.samples = 512;  // about 12 ms a ray
  ASSERT_TRUE(host.scan({slow}));
  ASSERT_TRUE(host.run_until([&] { return host.board.times_laser_on == 20; }, 10));
  host.answers_heartbeats = host.credits = false;
  const uint64_t silent_from = host.board.now;
  uint64_t last_light = 0;
  host.after_every_event = [&] {
    if (host.board.laser) last_light = host.board.now;
  };
  ASSERT_TRUE(host.run_until([&] { return state() == tg_State_STATE_PAUSED; }, 2));
  // The last frame the machine heard may be up to a heartbeat older than silent_from.
  EXPECT_LE(host.board.now - silent_from, kHostSilenceNs);
  host.run(3);
  EXPECT_LT(last_light - silent_from, 500'000'000u);
  EXPECT_FALSE(host.board.laser);
  EXPECT_EQ(state(), tg_State_STATE_PAUSED) << "only the host ends a pause";
  host.answers_heartbeats = host.credits = true;
  host.send_credit();
  host.run(0.5);
  EXPECT_EQ(state(), tg_State_STATE_PAUSED);
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_resume_tag));
  host.run_until([&] { return host.ended; }, 30);
  expect_whole_scan(1);
}

TEST_F(ControllerTest, PausesAtAnyInstantAndLosesNothing) {
  // Pause after every 13th event for 30 ms: in the middle of moves, settling, bursts.
  ASSERT_TRUE(host.scan({small_view(), small_view()}));
  int events = 0;
  while (!host.ended && events < 20'000) {
    host.run_until([&] { return ++events % 13 == 0 || host.ended; }, 1);
    if (state() != tg_State_STATE_SCANNING) continue;
    ASSERT_TRUE(host.accepted(tg_HostMessage_scan_pause_tag));
    EXPECT_FALSE(host.board.laser);
    const uint32_t times = host.board.times_laser_on;
    host.run(0.03);
    EXPECT_EQ(host.board.times_laser_on, times);
    ASSERT_TRUE(host.accepted(tg_HostMessage_scan_resume_tag));
  }
  expect_whole_scan(2);
  EXPECT_GT(events, 100);
}

TEST_F(ControllerTest, WithoutCreditItHoldsAndLosesNothing) {
  // 40 views of 77 rays are more batches than the ring holds.
  host.credits = false;
  ASSERT_TRUE(host.scan(std::vector<tg_View>(40, small_view())));
  host.run(120);
  EXPECT_EQ(state(), tg_State_STATE_SCANNING);
  EXPECT_FALSE(host.board.laser);
  EXPECT_EQ(host.items, 0u) << "nothing is sent without credit";
  const uint32_t times = host.board.times_laser_on;
  host.run(10);
  EXPECT_EQ(host.board.times_laser_on, times) << "and nothing is measured with the ring full";
  host.credits = true;
  host.credit_window = 3;
  host.send_credit();
  host.run_until([&] { return host.ended; }, 120);
  expect_whole_scan(40);
}

TEST_F(ControllerTest, AbortEndsTheScanWithWhatWasMeasured) {
  ASSERT_TRUE(host.scan({small_view(), small_view()}));
  ASSERT_TRUE(host.run_until([&] { return host.board.times_laser_on == 30; }, 10));
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_abort_tag));
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 1));
  EXPECT_TRUE(host.end.aborted);
  EXPECT_EQ(host.end.fault, tg_FaultCode_FAULT_NONE);
  EXPECT_EQ(state(), tg_State_STATE_READY);
  EXPECT_EQ(host.beams.size(), 29u) << "the ray under way is not measured";
  EXPECT_EQ(host.end.points, 29u);
  EXPECT_EQ(host.end.crc, host.crc());
  // And the next scan is whole.
  ASSERT_TRUE(host.scan({small_view()}));
  host.run_until([&] { return host.ended; }, 30);
  expect_whole_scan(1);
}

TEST_F(ControllerTest, AbortInReadyDropsWhatNobodyFetched) {
  host.credits = false;
  ASSERT_TRUE(host.scan({small_view()}));
  host.run(30);
  ASSERT_EQ(state(), tg_State_STATE_READY) << "two batches and the end fit the ring";
  tg_MachineMessage reply = host.ask([&] {
    tg_HostMessage load = tg_HostMessage_init_zero;
    load.which_body = tg_HostMessage_scan_load_tag;
    load.body.scan_load.plan_id = 99;
    load.body.scan_load.total_views = load.body.scan_load.views_count = 1;
    load.body.scan_load.views[0] = small_view();
    return load;
  }());
  ASSERT_EQ(reply.which_body, tg_MachineMessage_refused_tag);
  EXPECT_EQ(reply.body.refused.reason, tg_RefuseReason_REFUSE_UNDELIVERED);
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_abort_tag));
  host.credits = true;
  ASSERT_TRUE(host.scan({small_view()}));
  host.run_until([&] { return host.ended; }, 30);
  expect_whole_scan(1);
}

TEST_F(ControllerTest, RepeatedRequestIsNotExecutedTwice) {
  ASSERT_TRUE(host.load({small_view()}));
  tg_HostMessage start = tg_HostMessage_init_zero;
  start.which_body = tg_HostMessage_scan_start_tag;
  start.body.scan_start.plan_id = host.plan_id();
  for (int i = 0; i < 3; ++i) {
    host.replies.clear();
    host.transmit({Channel::kRequest, 5000}, start);
    host.run(0.01);
    ASSERT_TRUE(host.replies.contains(5000));
    EXPECT_EQ(host.replies[5000].which_body, tg_MachineMessage_done_tag) << "the same answer, not a refusal";
  }
  // The same id on another request is another request.
  host.transmit({Channel::kRequest, 5000}, [] {
    tg_HostMessage status = tg_HostMessage_init_zero;
    status.which_body = tg_HostMessage_get_status_tag;
    return status;
  }());
  host.run(0.01);
  EXPECT_EQ(host.replies[5000].which_body, tg_MachineMessage_status_tag);
}

TEST_F(ControllerTest, InterlockStopsEverythingAtOnce) {
  ASSERT_TRUE(host.scan({small_view()}));
  ASSERT_TRUE(host.run_until([&] { return host.board.times_laser_on == 10 && host.board.laser; }, 10));
  host.board.needed_inputs &= ~Inputs::kInterlockClosed;
  host.controller->on_interlock();
  EXPECT_FALSE(host.board.laser) << "in the interrupt itself";
  host.controller->poll();
  EXPECT_EQ(state(), tg_State_STATE_ESTOP);
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 1));
  EXPECT_TRUE(host.end.aborted);
  EXPECT_EQ(host.end.fault, tg_FaultCode_FAULT_INTERLOCK);
  EXPECT_EQ(host.beams.size(), 9u);
  EXPECT_EQ(host.end.crc, host.crc());
  ASSERT_EQ(host.faults.size(), 1u);
  EXPECT_EQ(host.faults[0].code, tg_FaultCode_FAULT_INTERLOCK);

  const auto refused = host.ask(tg_HostMessage_clear_fault_tag);
  ASSERT_EQ(refused.which_body, tg_MachineMessage_refused_tag);
  EXPECT_EQ(refused.body.refused.reason, tg_RefuseReason_REFUSE_STILL_FAULTY);
  host.board.needed_inputs |= Inputs::kInterlockClosed;
  host.run(1);
  EXPECT_EQ(state(), tg_State_STATE_ESTOP) << "latched";
  EXPECT_TRUE(host.accepted(tg_HostMessage_clear_fault_tag));
  EXPECT_EQ(state(), tg_State_STATE_IDLE) << "the motors may have been without current: home again";
}

TEST_F(ControllerTest, InterlockInAMoveLosesThePosition) {
  ASSERT_TRUE(host.scan({small_view()}));
  host.run(0.1);
  host.board.needed_inputs &= ~Inputs::kInterlockClosed;
  host.controller->on_interlock();
  host.controller->poll();
  const int64_t table = host.board.position[0];
  host.run(1);
  EXPECT_EQ(host.board.position[0], table) << "no further step";
  host.board.needed_inputs |= Inputs::kInterlockClosed;
  EXPECT_TRUE(host.accepted(tg_HostMessage_clear_fault_tag));
  EXPECT_EQ(state(), tg_State_STATE_IDLE);
}

struct FaultCase {
  const char* name;
  void (*break_it)(FakeBoard&);
  tg_FaultCode code;
};
void PrintTo(const FaultCase& fault, std::ostream* out) {
  *out << fault.name;
}

class ScanFault : public ControllerTest, public testing::WithParamInterface<FaultCase> {};

TEST_P(ScanFault, LatchesWithTheLaserOff) {
  tg_View view = small_view();
  view.columns = 40;
  view.rows = 10;
  view.a_step_urad = 300;
  ASSERT_TRUE(host.scan({view}));
  ASSERT_TRUE(host.run_until([&] { return host.board.times_laser_on == 10; }, 10));
  GetParam().break_it(host.board);
  ASSERT_TRUE(host.run_until([&] { return state() == tg_State_STATE_FAULT; }, 5)) << host.trouble();
  EXPECT_FALSE(host.board.laser);
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 1));
  EXPECT_TRUE(host.end.aborted);
  EXPECT_EQ(host.end.fault, GetParam().code);
  EXPECT_EQ(host.end.points + host.end.rejected, host.beams.size());
  EXPECT_EQ(host.end.crc, host.crc());
  EXPECT_EQ(host.ask(tg_HostMessage_get_status_tag).body.status.fault, GetParam().code);
}

INSTANTIATE_TEST_SUITE_P(
    Each, ScanFault,
    testing::Values(
        FaultCase{"mirror", [](FakeBoard& b) { b.needed_inputs &= ~Inputs::kMirrorsGood; },
                  tg_FaultCode_FAULT_MIRROR},
        FaultCase{"laser", [](FakeBoard& b) { b.needed_inputs &= ~Inputs::kLaserGood; },
                  tg_FaultCode_FAULT_LASER},
        FaultCase{"converter", [](FakeBoard& b) { b.stuck_converter = true; }, tg_FaultCode_FAULT_SAMPLING},
        FaultCase{"rail", [](FakeBoard& b) { b.ambient_codes = 70'000; }, tg_FaultCode_FAULT_SIGNAL},
        FaultCase{"assembly", [](FakeBoard& b) { b.camera_1_shift_mm = 0.5; },
                  tg_FaultCode_FAULT_MISASSEMBLED}),
    [](const auto& info) { return info.param.name; });

TEST_F(ControllerTest, AStoppedStepTimerLetsTheWatchdogBite) {
  ASSERT_TRUE(host.scan({small_view()}));
  host.run(0.1);
  host.board.step_edge[0] = host.board.step_edge[1] = FakeBoard::kNever;
  host.run(0.05);
  const uint64_t kicks = host.board.kicks;
  host.run(2);
  EXPECT_EQ(host.board.kicks, kicks);
}

TEST_F(ControllerTest, ARejectedBeamIsReportedWithItsReason) {
  struct Case {
    void (*spoil)(FakeBoard&);
    tg_RejectReason reason;
  };
  const Case cases[] = {
      {[](FakeBoard& b) { b.light_codes = 20; }, tg_RejectReason_REJECT_WEAK},
      {[](FakeBoard& b) { b.light_codes = 70'000; }, tg_RejectReason_REJECT_SATURATED},
      {[](FakeBoard& b) { b.ambient_codes = 50'000, b.light_codes = 2'000; }, tg_RejectReason_REJECT_AMBIENT},
      {[](FakeBoard& b) { b.camera_1_shift_mm = 0.5; }, tg_RejectReason_REJECT_INCONSISTENT},
      {[](FakeBoard& b) { b.plate_x_mm = -80; }, tg_RejectReason_REJECT_OUTSIDE_VOLUME},
  };
  const FakeBoard good;
  for (const Case& one : cases) {
    host.board.light_codes = good.light_codes;
    host.board.ambient_codes = good.ambient_codes;
    host.board.camera_1_shift_mm = 0;
    host.board.plate_x_mm = 0;
    ASSERT_TRUE(host.scan({small_view()}));
    ASSERT_TRUE(host.run_until([&] { return host.board.times_laser_on % kSmallViewRays == 40; }, 10));
    one.spoil(host.board);
    ASSERT_TRUE(host.run_until([&] { return host.ended; }, 30)) << host.trouble();
    ASSERT_EQ(host.beams.size(), kSmallViewRays) << "every beam is there, with or without a point";
    EXPECT_EQ(host.beams.back().reason, static_cast<uint32_t>(one.reason));
    EXPECT_EQ(host.beams.front().reason, 0u);
    EXPECT_NEAR(host.end.rejected, kSmallViewRays - 40, 1);
    EXPECT_EQ(host.end.points + host.end.rejected, kSmallViewRays);
    EXPECT_EQ(host.end.crc, host.crc());
    const BeamRecord& last = host.beams.back();
    EXPECT_NEAR(last.a_urad, target_of(small_view(), last.ray).a_urad, kUradPerMirrorCode / 2);
  }
}

}  // namespace
}  // namespace tetragauge
