// SPDX-License-Identifier: Apache-2.0
// What a host may ask for besides a scan: moving, aiming, calibration, self-test, counts, logs, restarts.
#include <gtest/gtest.h>

#include <vector>

#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"

namespace tetragauge {
namespace {

class ServiceTest : public testing::Test {
 protected:
  void SetUp() override {
    host.connect();
    ASSERT_TRUE(host.home()) << host.trouble();
  }
  tg_State state() const { return host.controller->state(); }
  tg_Status status() { return host.ask(tg_HostMessage_get_status_tag).body.status; }
  tg_HelloReply hello() { return host.ask(tg_HostMessage_hello_tag).body.hello_reply; }

  tg_MachineMessage jog(tg_AxisName axis, int32_t by) {
    tg_HostMessage message = request(tg_HostMessage_jog_tag);
    message.body.jog = {axis, by};
    return host.ask(message);
  }
  tg_MachineMessage move(tg_AxisName axis, int32_t to) {
    tg_HostMessage message = request(tg_HostMessage_move_axis_tag);
    message.body.move_axis = {axis, to};
    return host.ask(message);
  }
  tg_MachineMessage galvo(int32_t a_urad, int32_t b_urad) {
    tg_HostMessage message = request(tg_HostMessage_move_galvo_tag);
    message.body.move_galvo = {a_urad, b_urad};
    return host.ask(message);
  }
  tg_MachineMessage laser(bool on) {
    tg_HostMessage message = request(tg_HostMessage_laser_set_tag);
    message.body.laser_set.on = on;
    return host.ask(message);
  }
  static tg_HostMessage request(pb_size_t tag) {
    tg_HostMessage message = tg_HostMessage_init_zero;
    message.which_body = tag;
    return message;
  }
  void wait_for_rest() {
    ASSERT_TRUE(host.run_until([&] { return host.controller->resting(); }, 60)) << host.trouble();
  }

  // In chunks, then committed; the reply to the commit, or the first refusal.
  tg_MachineMessage write_calibration(const tg_Calibration& calibration) {
    uint8_t record[tg_Calibration_size];
    const size_t bytes = encode_calibration(calibration, record);
    const uint32_t crc = crc32c(record, bytes);
    for (size_t at = 0; at < bytes; at += 200) {
      tg_HostMessage write = request(tg_HostMessage_calibration_write_tag);
      tg_CalibrationChunk& chunk = write.body.calibration_write;
      chunk.offset = static_cast<uint32_t>(at);
      chunk.total = static_cast<uint32_t>(bytes);
      chunk.crc = crc;
      chunk.data.size = static_cast<pb_size_t>(std::min<size_t>(200, bytes - at));
      std::copy_n(record + at, chunk.data.size, chunk.data.bytes);
      const tg_MachineMessage reply = host.ask(write);
      if (reply.which_body != tg_MachineMessage_done_tag) return reply;
    }
    tg_HostMessage commit = request(tg_HostMessage_calibration_commit_tag);
    commit.body.calibration_commit = {static_cast<uint32_t>(bytes), crc};
    return host.ask(commit);
  }
  static tg_Calibration some_calibration() {
    MachineConfig config = nominal_config();
    config.galvo.a_zero_urad = 123.5;
    config.camera[1].distortion_x[3] = 0.01;
    tg_Calibration calibration = calibration_of(config);
    std::copy_n("ball plate 7", 13, calibration.id);
    calibration.u_cal_100nm = 73;
    return calibration;
  }
  void restart() {
    host.controller = std::make_unique<Controller<FakeBoard>>(host.board);
    host.controller->begin();
    host.connect();
  }

  TestHost host;
};

TEST_F(ServiceTest, GetClockTellsTheMachinesTime) {
  const tg_MachineMessage reply = host.ask(tg_HostMessage_get_clock_tag);
  ASSERT_EQ(reply.which_body, tg_MachineMessage_clock_tag);
  EXPECT_EQ(reply.body.clock.clock_us, host.board.now / 1000);
}

TEST_F(ServiceTest, MovesAnAxisWhereItIsToldAndNoFurther) {
  ASSERT_EQ(move(tg_AxisName_AXIS_TABLE, 45'000'000).which_body, tg_MachineMessage_done_tag);
  EXPECT_TRUE(status().moving);
  EXPECT_EQ(jog(tg_AxisName_AXIS_TABLE, 1).body.refused.reason, tg_RefuseReason_REFUSE_BUSY);
  EXPECT_EQ(host.ask(tg_HostMessage_home_tag).body.refused.reason, tg_RefuseReason_REFUSE_BUSY);
  ASSERT_EQ(move(tg_AxisName_AXIS_SLIDE, 12'345).which_body, tg_MachineMessage_done_tag)
      << "the other axis is free";
  wait_for_rest();
  EXPECT_EQ(status().table_udeg, 45'000'000);
  EXPECT_EQ(status().slide_um, 12'345);
  EXPECT_FALSE(status().moving);
  EXPECT_EQ(move(tg_AxisName_AXIS_SLIDE, 302'000).body.refused.reason, tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_EQ(move(tg_AxisName_AXIS_NONE, 0).body.refused.reason, tg_RefuseReason_REFUSE_OUT_OF_RANGE);
}

TEST_F(ServiceTest, JogIsRelativeAndCutAtTheSoftLimits) {
  jog(tg_AxisName_AXIS_SLIDE, 50'000);
  wait_for_rest();
  const int32_t at = status().slide_um;
  jog(tg_AxisName_AXIS_SLIDE, -10'000);
  wait_for_rest();
  EXPECT_EQ(status().slide_um, at - 10'000);
  jog(tg_AxisName_AXIS_SLIDE, 2'000'000'000);
  wait_for_rest();
  EXPECT_EQ(status().slide_um, 301'000) << "60,200 steps of 5 um";
  EXPECT_EQ(state(), tg_State_STATE_READY);
}

TEST_F(ServiceTest, AbortStopsAJogAndThePositionStaysKnown) {
  ASSERT_EQ(move(tg_AxisName_AXIS_SLIDE, 200'000).which_body, tg_MachineMessage_done_tag);
  host.run(1);
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_abort_tag));
  wait_for_rest();
  const tg_Status stopped = status();
  EXPECT_TRUE(stopped.homed);
  EXPECT_GT(stopped.slide_um, 10'000);
  EXPECT_LT(stopped.slide_um, 190'000);
  // The edges made and the position told agree: nominal home edge at -400 steps, 5 um a step.
  EXPECT_EQ((host.board.position[1] - host.board.slide_home - 400) * 5, stopped.slide_um);
  EXPECT_EQ(state(), tg_State_STATE_READY);
}

TEST_F(ServiceTest, JogsUnhomedAndIsStoppedThere) {
  restart();
  ASSERT_EQ(state(), tg_State_STATE_IDLE);
  EXPECT_EQ(move(tg_AxisName_AXIS_TABLE, 0).body.refused.reason, tg_RefuseReason_REFUSE_STATE);
  const int64_t before = host.board.position[1];
  ASSERT_EQ(jog(tg_AxisName_AXIS_SLIDE, 1'000).which_body, tg_MachineMessage_done_tag);
  wait_for_rest();
  EXPECT_EQ(host.board.position[1] - before, 200) << "5 um a step";
  ASSERT_EQ(jog(tg_AxisName_AXIS_SLIDE, 100'000).which_body, tg_MachineMessage_done_tag);
  host.run(0.5);
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_abort_tag));
  wait_for_rest();
  EXPECT_LT(host.board.position[1] - before, 20'000);
  EXPECT_EQ(state(), tg_State_STATE_IDLE);
  ASSERT_TRUE(host.home()) << host.trouble();
}

TEST_F(ServiceTest, AnEndSwitchStopsAJogAndOneGetsOffItAgain) {
  restart();
  ASSERT_EQ(jog(tg_AxisName_AXIS_SLIDE, -400'000).which_body, tg_MachineMessage_done_tag);
  ASSERT_TRUE(host.run_until([&] { return state() == tg_State_STATE_FAULT; }, 60)) << host.trouble();
  EXPECT_EQ(status().fault, tg_FaultCode_FAULT_LIMIT);
  const int64_t at = host.board.position[1];
  host.run(1);
  EXPECT_EQ(host.board.position[1], at) << "stands still";
  ASSERT_TRUE(host.accepted(tg_HostMessage_clear_fault_tag));
  ASSERT_EQ(state(), tg_State_STATE_IDLE);
  ASSERT_EQ(jog(tg_AxisName_AXIS_SLIDE, 5'000).which_body, tg_MachineMessage_done_tag);
  wait_for_rest();
  EXPECT_EQ(state(), tg_State_STATE_IDLE);
  ASSERT_TRUE(host.home()) << host.trouble();
}

TEST_F(ServiceTest, PointsTheMirrorsWithinTheirLimit) {
  ASSERT_EQ(galvo(-1'430, 2'858).which_body, tg_MachineMessage_done_tag);
  EXPECT_EQ(host.board.mirror_a, -238) << "6 urad a code";
  EXPECT_EQ(host.board.mirror_b, 476);
  EXPECT_EQ(status().a_urad, -1'428) << "as driven";
  EXPECT_EQ(status().b_urad, 2'856);
  EXPECT_EQ(galvo(174'534, 0).body.refused.reason, tg_RefuseReason_REFUSE_OUT_OF_RANGE);
  EXPECT_EQ(galvo(0, INT32_MIN).body.refused.reason, tg_RefuseReason_REFUSE_OUT_OF_RANGE);
}

TEST_F(ServiceTest, AimsWithTheLaserOnInScanningOnly) {
  ASSERT_EQ(laser(true).which_body, tg_MachineMessage_done_tag);
  EXPECT_EQ(state(), tg_State_STATE_SCANNING);
  EXPECT_TRUE(host.board.laser);
  EXPECT_TRUE(status().aiming);
  ASSERT_EQ(galvo(6'000, -6'000).which_body, tg_MachineMessage_done_tag);
  host.run(2);
  EXPECT_TRUE(host.board.laser) << "as long as the host is there";
  EXPECT_EQ(host.ask(tg_HostMessage_home_tag).body.refused.reason, tg_RefuseReason_REFUSE_STATE);
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_pause_tag));
  EXPECT_FALSE(host.board.laser);
  EXPECT_EQ(laser(true).body.refused.reason, tg_RefuseReason_REFUSE_STATE);
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_resume_tag));
  EXPECT_TRUE(host.board.laser);
  ASSERT_EQ(laser(false).which_body, tg_MachineMessage_done_tag);
  EXPECT_EQ(state(), tg_State_STATE_READY);
  EXPECT_FALSE(host.board.laser);
  EXPECT_FALSE(status().aiming);
  // And by abort.
  ASSERT_EQ(laser(true).which_body, tg_MachineMessage_done_tag);
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_abort_tag));
  EXPECT_EQ(state(), tg_State_STATE_READY);
  EXPECT_FALSE(host.board.laser);
  // A scan is whole after it.
  ASSERT_TRUE(host.scan({small_view()}));
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 30)) << host.trouble();
  EXPECT_EQ(host.beams.size(), kSmallViewRays);
  EXPECT_EQ(host.end.crc, host.crc());
}

TEST_F(ServiceTest, SilenceEndsAimingAndResumeGoesOn) {
  ASSERT_EQ(laser(true).which_body, tg_MachineMessage_done_tag);
  host.answers_heartbeats = host.credits = false;
  const uint64_t silent_from = host.board.now;
  ASSERT_TRUE(host.run_until([&] { return !host.board.laser; }, 2));
  EXPECT_LT(host.board.now - silent_from, 500'000'000u);
  EXPECT_EQ(state(), tg_State_STATE_PAUSED);
  host.answers_heartbeats = host.credits = true;
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_resume_tag));
  EXPECT_TRUE(host.board.laser);
  host.board.needed_inputs &= ~Inputs::kInterlockClosed;
  host.controller->on_interlock();
  EXPECT_FALSE(host.board.laser);
  host.run(0.01);
  EXPECT_EQ(state(), tg_State_STATE_ESTOP);
  EXPECT_FALSE(status().aiming);
}

TEST_F(ServiceTest, AScanKeepsItsMirrorsAndItsLaser) {
  ASSERT_TRUE(host.scan({small_view()}));
  ASSERT_TRUE(host.run_until([&] { return host.board.times_laser_on == 10; }, 10));
  EXPECT_EQ(galvo(0, 0).body.refused.reason, tg_RefuseReason_REFUSE_BUSY);
  EXPECT_EQ(laser(false).body.refused.reason, tg_RefuseReason_REFUSE_BUSY);
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 30)) << host.trouble();
  EXPECT_EQ(host.beams.size(), kSmallViewRays);
}

TEST_F(ServiceTest, CalibrationIsStoredReadBackAndInForceAfterARestart) {
  EXPECT_STREQ(hello().calibration_id, "");
  const uint32_t nominal_crc = hello().config_crc;
  const tg_Calibration calibration = some_calibration();
  ASSERT_EQ(write_calibration(calibration).which_body, tg_MachineMessage_done_tag);
  EXPECT_EQ(state(), tg_State_STATE_IDLE) << "needs homing again";
  EXPECT_STREQ(hello().calibration_id, "ball plate 7");
  EXPECT_EQ(hello().u_cal_100nm, 73u);
  const uint32_t crc = hello().config_crc;
  EXPECT_NE(crc, nominal_crc);
  MachineConfig config;
  use_calibration(calibration, &config);
  EXPECT_EQ(crc, config_crc(config));

  restart();
  EXPECT_STREQ(hello().calibration_id, "ball plate 7");
  EXPECT_EQ(hello().config_crc, crc);

  // What is read back is what was written.
  std::vector<uint8_t> record;
  for (;;) {
    tg_HostMessage read = request(tg_HostMessage_calibration_read_tag);
    read.body.calibration_read.offset = static_cast<uint32_t>(record.size());
    const tg_MachineMessage reply = host.ask(read);
    ASSERT_EQ(reply.which_body, tg_MachineMessage_calibration_tag);
    const tg_CalibrationChunk& chunk = reply.body.calibration;
    record.insert(record.end(), chunk.data.bytes, chunk.data.bytes + chunk.data.size);
    if (record.size() < chunk.total) continue;
    EXPECT_EQ(chunk.crc, crc32c(record.data(), record.size()));
    break;
  }
  uint8_t written[tg_Calibration_size];
  ASSERT_EQ(record.size(), encode_calibration(calibration, written));
  EXPECT_TRUE(std::equal(record.begin(), record.end(), written));

  // Emptied: nominal again.
  tg_HostMessage empty = request(tg_HostMessage_calibration_commit_tag);
  ASSERT_EQ(host.ask(empty).which_body, tg_MachineMessage_done_tag);
  restart();
  EXPECT_STREQ(hello().calibration_id, "");
  EXPECT_EQ(hello().config_crc, nominal_crc);
}

TEST_F(ServiceTest, ACalibrationIsClaimedOnlyWhileItsNumbersAreInForce) {
  ASSERT_EQ(write_calibration(some_calibration()).which_body, tg_MachineMessage_done_tag);
  tg_HostMessage set = request(tg_HostMessage_set_config_tag);
  set.body.set_config.which_part = tg_Config_galvo_tag;
  set.body.set_config.part.galvo = some_calibration().galvo;
  set.body.set_config.part.galvo.a_zero_urad += 0.5;
  ASSERT_EQ(host.ask(set).which_body, tg_MachineMessage_done_tag);
  EXPECT_STREQ(hello().calibration_id, "");
  EXPECT_EQ(hello().u_cal_100nm, 0u);
  set.body.set_config.part.galvo.a_zero_urad -= 0.5;
  ASSERT_EQ(host.ask(set).which_body, tg_MachineMessage_done_tag);
  EXPECT_STREQ(hello().calibration_id, "ball plate 7");
}

TEST_F(ServiceTest, ABadCalibrationIsRefusedAndChangesNothing) {
  const uint32_t crc = hello().config_crc;
  tg_Calibration calibration = some_calibration();
  calibration.camera_1.focal_mm = -1;
  EXPECT_EQ(write_calibration(calibration).body.refused.reason, tg_RefuseReason_REFUSE_STORAGE);
  calibration = some_calibration();
  calibration.has_volume = false;
  EXPECT_EQ(write_calibration(calibration).body.refused.reason, tg_RefuseReason_REFUSE_STORAGE);
  EXPECT_EQ(hello().config_crc, crc);
  EXPECT_EQ(state(), tg_State_STATE_READY);
}

TEST_F(ServiceTest, SelfTestRunsInTimeAndOtherRequestsAreAnsweredMeanwhile) {
  const uint64_t asked = host.board.now;
  const uint32_t id = host.request(tg_HostMessage_self_test_tag);
  host.run(0.0005);
  EXPECT_FALSE(host.replies.contains(id));
  EXPECT_EQ(host.ask(tg_HostMessage_home_tag).body.refused.reason, tg_RefuseReason_REFUSE_BUSY);
  EXPECT_EQ(status().state, tg_State_STATE_READY);
  ASSERT_TRUE(host.run_until([&] { return host.replies.contains(id); }, 1));
  EXPECT_LT(host.board.now - asked, 300'000'000u);
  const tg_SelfTestReply& reply = host.replies[id].body.self_test;
  ASSERT_EQ(host.replies[id].which_body, tg_MachineMessage_self_test_tag);
  std::map<tg_SelfTestCheck, tg_SelfTestItem> items;
  for (pb_size_t i = 0; i < reply.items_count; ++i) items[reply.items[i].check] = reply.items[i];
  ASSERT_EQ(items.size(), size_t{_tg_SelfTestCheck_MAX}) << "each check once";
  for (const auto& [check, item] : items) {
    EXPECT_NE(item.result, tg_SelfTestResult_SELF_TEST_FAILED)
        << "check " << check << ", value " << item.value;
    EXPECT_NE(item.result, tg_SelfTestResult_SELF_TEST_NONE);
  }
  EXPECT_EQ(items[tg_SelfTestCheck_CHECK_CONVERTER].value, 10'000) << "ns a sample";
  EXPECT_EQ(items[tg_SelfTestCheck_CHECK_DARK_CAMERA_1].value, 50)
      << "half the pair's 100 codes of ambient light";
  ASSERT_EQ(reply.dark_codes_count, 8u);
  for (const int32_t code : reply.dark_codes) EXPECT_EQ(code, 50);
  EXPECT_EQ(items[tg_SelfTestCheck_CHECK_CLOCK].result, tg_SelfTestResult_SELF_TEST_ABSENT);
  EXPECT_EQ(host.board.times_laser_on, 0u);
}

TEST_F(ServiceTest, SelfTestFindsWhatIsBroken) {
  ASSERT_EQ(write_calibration(some_calibration()).which_body, tg_MachineMessage_done_tag);
  const auto failed = [&] {
    const tg_SelfTestReply reply = host.ask(tg_HostMessage_self_test_tag).body.self_test;
    std::set<tg_SelfTestCheck> checks;
    for (pb_size_t i = 0; i < reply.items_count; ++i) {
      if (reply.items[i].result == tg_SelfTestResult_SELF_TEST_FAILED) checks.insert(reply.items[i].check);
    }
    return checks;
  };
  using Checks = std::set<tg_SelfTestCheck>;
  EXPECT_EQ(failed(), Checks{});
  host.board.store.words[1][30] ^= 4;
  EXPECT_EQ(failed(), Checks{tg_SelfTestCheck_CHECK_STORE});
  host.board.store.words[1][30] ^= 4;
  host.board.ambient_codes = 50'000;
  EXPECT_EQ(failed(), (Checks{tg_SelfTestCheck_CHECK_DARK_CAMERA_1, tg_SelfTestCheck_CHECK_DARK_CAMERA_2}));
  host.board.ambient_codes = 100;
  host.board.needed_inputs &= ~Inputs::kMirrorsGood;
  host.run(0.01);
  ASSERT_EQ(state(), tg_State_STATE_FAULT);
  EXPECT_EQ(failed(), Checks{tg_SelfTestCheck_CHECK_MIRRORS}) << "and runs in FAULT, to tell why";
  host.board.needed_inputs |= Inputs::kMirrorsGood;
  host.board.stuck_converter = true;
  const Checks without_samples = failed();
  EXPECT_TRUE(without_samples.contains(tg_SelfTestCheck_CHECK_CONVERTER));
  EXPECT_TRUE(without_samples.contains(tg_SelfTestCheck_CHECK_NOISE_CAMERA_2));
}

TEST_F(ServiceTest, CountsWhatHappened) {
  ASSERT_TRUE(host.scan({small_view()}));
  ASSERT_TRUE(host.run_until([&] { return host.ended; }, 30));
  host.board.to_machine.insert(host.board.to_machine.end(), {1, 2, 3, 0});
  const tg_Stats stats = host.ask(tg_HostMessage_get_stats_tag).body.stats;
  EXPECT_EQ(stats.points, kSmallViewRays);
  ASSERT_EQ(stats.rejected_count, 6u);
  EXPECT_EQ(stats.rejected[tg_RejectReason_REJECT_WEAK], 0u);
  EXPECT_EQ(stats.bad_frames, 1u);
  EXPECT_GT(stats.frames_in, 5u);
  EXPECT_GT(stats.frames_out, 5u);
  EXPECT_GE(stats.ring_most, 1u);
  EXPECT_LE(stats.ring_most, host.items);
  EXPECT_EQ(stats.faults, 0u);
  EXPECT_EQ(stats.silences, 0u);
  EXPECT_EQ(stats.steps_late, 0u);
}

TEST_F(ServiceTest, LogsAreSentAndWhatDoesNotFitIsCounted) {
  LogQueue queue;
  for (uint32_t i = 0; i < LogQueue::kLines + 3; ++i)
    queue.add(tg_LogLevel_LOG_INFO, i, i == 0 ? "first" : "later");
  EXPECT_EQ(queue.dropped(), 3u);
  tg_Log log = tg_Log_init_zero;
  queue.take(&log);
  EXPECT_STREQ(log.text, "first");
  uint32_t left = 0;
  for (; !queue.empty(); ++left) queue.take(&log);
  EXPECT_EQ(left, LogQueue::kLines - 1);
  EXPECT_EQ(log.clock_us, LogQueue::kLines - 1) << "the newest are dropped";
}

TEST_F(ServiceTest, RebootsAfterItsReplyIsOut) {
  host.board.line_room = 1;
  const uint32_t id = host.request(tg_HostMessage_reboot_tag);
  ASSERT_TRUE(host.run_until([&] { return host.board.restart_asked; }, 1));
  host.run(0);
  ASSERT_TRUE(host.replies.contains(id));
  EXPECT_EQ(host.replies[id].which_body, tg_MachineMessage_done_tag);
  EXPECT_FALSE(host.board.bootloader_asked);
  host.request(tg_HostMessage_get_status_tag);
  const size_t replies = host.replies.size();
  host.run(1);
  EXPECT_EQ(host.replies.size(), replies) << "the firmware is gone";
}

TEST_F(ServiceTest, EntersTheBootloaderEvenWhenNobodyListens) {
  host.board.line_room = 0;
  host.request(tg_HostMessage_enter_bootloader_tag);
  ASSERT_TRUE(host.run_until([&] { return host.board.bootloader_asked; }, 3));
}

}  // namespace
}  // namespace tetragauge
