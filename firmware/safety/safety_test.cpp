// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>

#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"
#include "protocol/state_name.hpp"

namespace tetragauge {
namespace {

// protocol/README.md's table, written down once more: the letters of the states a request is legal in.
// B boot, I idle, H homing, R ready, A armed, S scanning, P paused, F fault, E estop.
const std::map<uint32_t, std::string> kLegal = {
    {tg_HostMessage_hello_tag, "BIHRASPFE"},
    {tg_HostMessage_get_status_tag, "BIHRASPFE"},
    {tg_HostMessage_get_config_tag, "BIHRASPFE"},
    {tg_HostMessage_set_config_tag, "IRA"},
    {tg_HostMessage_home_tag, "IRA"},
    {tg_HostMessage_scan_load_tag, "RA"},
    {tg_HostMessage_scan_start_tag, "A"},
    {tg_HostMessage_scan_pause_tag, "SP"},
    {tg_HostMessage_scan_resume_tag, "PS"},
    {tg_HostMessage_scan_abort_tag, "IASPR"},
    {tg_HostMessage_clear_fault_tag, "FEIR"},
    {tg_HostMessage_measure_rays_tag, "RA"},
    {tg_HostMessage_get_clock_tag, "BIHRASPFE"},
    {tg_HostMessage_get_stats_tag, "BIHRASPFE"},
    {tg_HostMessage_jog_tag, "IR"},
    {tg_HostMessage_move_axis_tag, "R"},
    {tg_HostMessage_move_galvo_tag, "IRS"},
    {tg_HostMessage_laser_set_tag, "RSP"},
    {tg_HostMessage_calibration_read_tag, "BIHRASPFE"},
    {tg_HostMessage_calibration_write_tag, "IR"},
    {tg_HostMessage_calibration_commit_tag, "IR"},
    {tg_HostMessage_self_test_tag, "IRFE"},
    {tg_HostMessage_enter_bootloader_tag, "IRAFE"},
    {tg_HostMessage_reboot_tag, "IRAFE"},
};
const char kLetters[] = "BIHRASPFE";

void bring_to(TestHost& host, tg_State state) {
  host.connect();
  if (state == tg_State_STATE_IDLE) return;
  if (state == tg_State_STATE_FAULT) {
    host.board.needed_inputs &= ~Inputs::kMirrorsGood;
    host.run(0.01);
    return;
  }
  if (state == tg_State_STATE_ESTOP) {
    host.board.needed_inputs &= ~Inputs::kInterlockClosed;
    host.run(0.01);
    return;
  }
  if (state == tg_State_STATE_HOMING) {
    ASSERT_TRUE(host.accepted(tg_HostMessage_home_tag));
    return;
  }
  ASSERT_TRUE(host.home());
  if (state == tg_State_STATE_READY) return;
  ASSERT_TRUE(host.load({small_view()}));
  if (state == tg_State_STATE_ARMED) return;
  ASSERT_TRUE(host.start());
  if (state == tg_State_STATE_SCANNING) return;
  ASSERT_TRUE(host.accepted(tg_HostMessage_scan_pause_tag));
}

TEST(StateTable, EveryRequestInEveryStateIsTakenOrRefusedAsDocumented) {
  int refused = 0, taken = 0;
  for (int s = tg_State_STATE_IDLE; s <= tg_State_STATE_ESTOP; ++s) {
    const auto state = static_cast<tg_State>(s);
    for (const auto& [request, legal] : kLegal) {
      TestHost host;
      bring_to(host, state);
      ASSERT_EQ(host.controller->state(), state);
      const tg_MachineMessage reply = host.ask(static_cast<pb_size_t>(request));
      const bool by_state = reply.which_body == tg_MachineMessage_refused_tag &&
                            reply.body.refused.reason == tg_RefuseReason_REFUSE_STATE;
      const bool is_legal = legal.find(kLetters[s]) != std::string::npos;
      EXPECT_EQ(by_state, !is_legal) << state_name(state) << ", request " << request;
      if (by_state) {
        EXPECT_EQ(reply.body.refused.state, state);
        EXPECT_STREQ(reply.body.refused.detail, state_name(state));
        EXPECT_EQ(host.controller->state(), state) << "a refused request changes nothing";
      }
      ++(by_state ? refused : taken);
    }
  }
  EXPECT_GT(refused, 30);
  EXPECT_GT(taken, 30);
}

TEST(StateTable, UnknownAndBrokenRequestsAreRefused) {
  TestHost host;
  host.connect();
  // An event on the request channel.
  tg_HostMessage event = tg_HostMessage_init_zero;
  event.which_body = tg_HostMessage_heartbeat_ack_tag;
  EXPECT_EQ(host.ask(event).body.refused.reason, tg_RefuseReason_REFUSE_UNKNOWN);
  // A good frame whose payload is no message.
  const uint8_t nonsense[] = {0xFF, 0xFF, 0xFF};
  uint8_t wire[kFrameWireBytes];
  const size_t bytes = encode_frame({Channel::kRequest, 900}, nonsense, sizeof nonsense, wire);
  host.board.to_machine.insert(host.board.to_machine.end(), wire, wire + bytes);
  host.run(0.01);
  ASSERT_TRUE(host.replies.contains(900));
  EXPECT_EQ(host.replies[900].body.refused.reason, tg_RefuseReason_REFUSE_MALFORMED);
}

TEST(StateTable, TransitionsAreThoseOfThePicture) {
  const std::map<char, std::string> picture = {{'B', "IFE"},    {'I', "HFE"},    {'H', "RFE"},
                                               {'R', "IHASFE"}, {'A', "IHRSFE"}, {'S', "RPFE"},
                                               {'P', "RSFE"},   {'F', "IRE"},    {'E', "IR"}};
  for (int from = 0; from < kStates; ++from) {
    for (int to = 0; to < kStates; ++to) {
      EXPECT_EQ(transition_allowed(static_cast<tg_State>(from), static_cast<tg_State>(to)),
                picture.at(kLetters[from]).find(kLetters[to]) != std::string::npos)
          << kLetters[from] << kLetters[to];
    }
  }
}

// Whatever is asked for and whatever breaks, in any order: the laser is on only in SCANNING with interlock
// closed, mirrors and laser good, a host heard within 500 ms; states change only along the table; and the
// machine can be brought back to work.
TEST(Safety, LaserIsNeverOnWhereItMustNotBe) {
  std::set<tg_State> visited;
  uint32_t times_on = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 engine(seed);
    const auto random = [&engine](uint32_t n) { return static_cast<uint32_t>(engine()) % n; };
    TestHost host;
    uint64_t last_sent = 0;
    tg_State before = host.controller->state();
    const auto check = [&] {
      const tg_State now = host.controller->state();
      if (now != before) {
        // Several transitions may lie between two looks at most through the ones allowed.
        bool reachable = transition_allowed(before, now);
        for (int via = 0; via < kStates && !reachable; ++via) {
          reachable = transition_allowed(before, static_cast<tg_State>(via)) &&
                      transition_allowed(static_cast<tg_State>(via), now);
        }
        ASSERT_TRUE(reachable) << state_name(before) << " to " << state_name(now);
      }
      before = now;
      visited.insert(now);
      if (!host.board.laser) return;
      ASSERT_EQ(now, tg_State_STATE_SCANNING);
      ASSERT_EQ(host.board.needed_inputs & kNeededInputs, kNeededInputs);
      ASSERT_LT(host.board.now - last_sent, 500'000'000u);
    };
    host.after_every_event = [&] {
      check();
      if (host.answers_heartbeats) last_sent = host.board.now;
    };
    host.board.when_laser_goes_on = [&] { ++times_on; };
    host.connect();
    for (int action = 0; action < 120; ++action) {
      last_sent = host.board.now;
      switch (random(16)) {
        case 0:
        case 1:
          host.home();
          break;
        case 2:
          host.load({small_view()});
          break;
        case 3:
        case 4:
          host.scan({small_view()});
          break;
        case 5:
          host.request(tg_HostMessage_scan_pause_tag);
          break;
        case 6:
        case 7:
          host.request(tg_HostMessage_scan_resume_tag);
          break;
        case 8:
          host.request(tg_HostMessage_scan_abort_tag);
          break;
        case 9:
          host.board.needed_inputs ^= Inputs::kInterlockClosed;
          break;
        case 10:
          host.board.needed_inputs ^= random(2) ? Inputs::kMirrorsGood : Inputs::kLaserGood;
          break;
        case 11:
          host.board.needed_inputs = kNeededInputs;
          host.request(tg_HostMessage_clear_fault_tag);
          break;
        case 12:
          host.answers_heartbeats = host.credits = false;
          break;
        case 13:
          host.answers_heartbeats = host.credits = true;
          break;
        default:
          break;
      }
      host.controller->on_interlock();
      host.controller->poll();
      check();
      if (testing::Test::HasFatalFailure()) return;
      host.run(0.001 * random(400));
      if (testing::Test::HasFatalFailure()) return;
    }
    // Back to work.
    host.board.needed_inputs = kNeededInputs;
    host.answers_heartbeats = host.credits = true;
    host.run(0.2);
    host.accepted(tg_HostMessage_clear_fault_tag);
    host.accepted(tg_HostMessage_scan_abort_tag);
    host.run(20);
    ASSERT_TRUE(host.home()) << seed << ": " << host.trouble();
    host.accepted(tg_HostMessage_scan_abort_tag);
    ASSERT_TRUE(host.scan({small_view()})) << seed << ": " << host.trouble();
    ASSERT_TRUE(host.run_until([&] { return host.ended; }, 30)) << seed << ": " << host.trouble();
    ASSERT_EQ(host.beams.size(), kSmallViewRays);
  }
  EXPECT_EQ(visited.size(), 8u) << "all states but BOOT, which ends in begin()";
  EXPECT_GT(times_on, 1000u);
}

TEST(Safety, StartsInEstopWithAnOpenInterlock) {
  FakeBoard board;
  board.needed_inputs &= ~Inputs::kInterlockClosed;
  const auto controller = std::make_unique<Controller<FakeBoard>>(board);
  EXPECT_EQ(controller->state(), tg_State_STATE_BOOT);
  controller->begin();
  EXPECT_EQ(controller->state(), tg_State_STATE_ESTOP);
}

}  // namespace
}  // namespace tetragauge
