// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/test_host.hpp"
#include "firmware/test_views.hpp"
#include "protocol/state_name.hpp"

namespace tetragauge {
namespace {

// Of protocol/README.md's table of requests: names, tags, and what stands there.
const std::map<std::string, uint32_t> kRequestNames = {
    {"hello", tg_HostMessage_hello_tag},
    {"get_status", tg_HostMessage_get_status_tag},
    {"get_config", tg_HostMessage_get_config_tag},
    {"get_clock", tg_HostMessage_get_clock_tag},
    {"get_stats", tg_HostMessage_get_stats_tag},
    {"set_config", tg_HostMessage_set_config_tag},
    {"clear_fault", tg_HostMessage_clear_fault_tag},
    {"home", tg_HostMessage_home_tag},
    {"jog", tg_HostMessage_jog_tag},
    {"move_axis", tg_HostMessage_move_axis_tag},
    {"move_galvo", tg_HostMessage_move_galvo_tag},
    {"laser_set", tg_HostMessage_laser_set_tag},
    {"scan_load", tg_HostMessage_scan_load_tag},
    {"measure_rays", tg_HostMessage_measure_rays_tag},
    {"scan_start", tg_HostMessage_scan_start_tag},
    {"scan_pause", tg_HostMessage_scan_pause_tag},
    {"scan_resume", tg_HostMessage_scan_resume_tag},
    {"scan_abort", tg_HostMessage_scan_abort_tag},
    {"calibration_read", tg_HostMessage_calibration_read_tag},
    {"calibration_write", tg_HostMessage_calibration_write_tag},
    {"calibration_commit", tg_HostMessage_calibration_commit_tag},
    {"self_test", tg_HostMessage_self_test_tag},
    {"enter_bootloader", tg_HostMessage_enter_bootloader_tag},
    {"reboot", tg_HostMessage_reboot_tag},
};

struct Row {
  std::set<tg_State> states;
  uint32_t needs = 0;
};

std::set<std::string> words_of(const std::string& cell) {
  std::istringstream in(cell);
  return {std::istream_iterator<std::string>(in), {}};
}

// By tag. A row: | name | states | needs | answer |
std::map<uint32_t, Row> table_of_readme() {
  std::map<uint32_t, Row> table;
  std::ifstream readme(TETRAGAUGE_PROTOCOL_README);
  for (std::string line; std::getline(readme, line);) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, '|');) cells.push_back(cell);
    if (cells.size() < 5) continue;
    const std::set<std::string> name = words_of(cells[1]);
    if (name.size() != 1 || !kRequestNames.contains(*name.begin())) continue;
    Row& row = table[kRequestNames.at(*name.begin())];
    const std::set<std::string> states = words_of(cells[2]), needs = words_of(cells[3]);
    size_t known = 0;
    for (int s = 0; s < kStates; ++s) {
      const bool named = states.contains(state_name(static_cast<tg_State>(s)));
      known += named;
      if (named || states.contains("every")) row.states.insert(static_cast<tg_State>(s));
    }
    EXPECT_EQ(known, states.contains("every") ? 0 : states.size()) << line;
    for (const std::string& need : needs) {
      EXPECT_TRUE(need == "rest" || need == "quiet" || need == "over") << line;
      row.needs |= need == "rest" ? kNeedsRest : need == "quiet" ? kNeedsQuiet : kNeedsScanOver;
    }
  }
  return table;
}
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

TEST(StateTable, IsWhatTheReadmeSays) {
  const std::map<uint32_t, Row> table = table_of_readme();
  EXPECT_EQ(table.size(), kRequestNames.size());
  const std::set<uint32_t> events = {tg_HostMessage_heartbeat_ack_tag, tg_HostMessage_points_credit_tag,
                                     tg_HostMessage_points_resend_tag};
  for (uint32_t tag = 1; tag < 64; ++tag) {
    const auto row = table.find(tag);
    for (int s = 0; s < kStates; ++s) {
      const auto state = static_cast<tg_State>(s);
      const bool legal = row != table.end() ? row->second.states.contains(state) : events.contains(tag);
      EXPECT_EQ(request_allowed(state, tag), legal) << state_name(state) << ", request " << tag;
    }
    EXPECT_EQ(request_needs(tag), row != table.end() ? row->second.needs : 0u) << "request " << tag;
  }
}

TEST(StateTable, EveryRequestInEveryStateIsTakenOrRefusedAsDocumented) {
  int refused = 0, taken = 0;
  for (int s = tg_State_STATE_IDLE; s <= tg_State_STATE_ESTOP; ++s) {
    const auto state = static_cast<tg_State>(s);
    for (const auto& [request, row] : table_of_readme()) {
      TestHost host;
      bring_to(host, state);
      ASSERT_EQ(host.controller->state(), state);
      const uint32_t id = host.request(static_cast<pb_size_t>(request));
      // In one poll, but for what takes time.
      host.run(0);
      const bool takes_time =
          request == tg_HostMessage_self_test_tag || request == tg_HostMessage_calibration_commit_tag;
      EXPECT_TRUE(host.replies.contains(id) || takes_time) << state_name(state) << ", request " << request;
      ASSERT_TRUE(host.run_until([&] { return host.replies.contains(id); }, 0.3))
          << state_name(state) << ", request " << request;
      const tg_MachineMessage reply = host.replies[id];
      const bool by_state = reply.which_body == tg_MachineMessage_refused_tag &&
                            reply.body.refused.reason == tg_RefuseReason_REFUSE_STATE;
      EXPECT_EQ(by_state, !row.states.contains(state)) << state_name(state) << ", request " << request;
      if (by_state) {
        EXPECT_EQ(reply.body.refused.state, state);
        EXPECT_STREQ(reply.body.refused.detail, state_name(state));
        EXPECT_EQ(host.controller->state(), state) << "a refused request changes nothing";
      }
      ++(by_state ? refused : taken);
    }
  }
  EXPECT_GT(refused, 60);
  EXPECT_GT(taken, 60);
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
                                               {'P', "RSFE"},   {'F', "IRE"},    {'E', "I"}};
  for (int from = 0; from < kStates; ++from) {
    for (int to = 0; to < kStates; ++to) {
      EXPECT_EQ(transition_allowed(static_cast<tg_State>(from), static_cast<tg_State>(to)),
                picture.at(kLetters[from]).find(kLetters[to]) != std::string::npos)
          << kLetters[from] << kLetters[to];
    }
  }
}

// Whatever is asked for and whatever breaks, in any order, with rubbish on the line: the laser is on only in
// SCANNING with interlock closed, mirrors and laser good, a host heard within 500 ms, and off when the
// interlock's interrupt returns; states change only along the table; each request is answered exactly once;
// and the machine can be brought back to work.
TEST(Safety, LaserIsNeverOnWhereItMustNotBe) {
  std::set<tg_State> visited;
  uint32_t times_on = 0, times_aimed = 0, answered = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 engine(seed);
    const auto random = [&engine](uint32_t n) { return static_cast<uint32_t>(engine()) % n; };
    TestHost host;
    tg_State before = host.controller->state();
    const auto check = [&] {
      const tg_State now = host.controller->state();
      if (now != before) {
        // One poll may take two steps, as from SCANNING by way of READY.
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
      ASSERT_LT(host.board.now - host.last_sent_ns, 500'000'000u);
    };
    host.after_every_event = check;
    host.board.when_laser_goes_on = [&] { ++times_on; };
    host.connect();
    std::vector<uint32_t> asked;
    const auto ask = [&](tg_HostMessage message) { asked.push_back(host.request(message)); };
    const auto request = [](pb_size_t tag) {
      tg_HostMessage message = tg_HostMessage_init_zero;
      message.which_body = tag;
      return message;
    };
    for (int action = 0; action < 120; ++action) {
      switch (random(24)) {
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
          ask(request(tg_HostMessage_scan_pause_tag));
          break;
        case 6:
        case 7:
          ask(request(tg_HostMessage_scan_resume_tag));
          break;
        case 8:
          ask(request(tg_HostMessage_scan_abort_tag));
          break;
        case 9:
          host.board.needed_inputs ^= Inputs::kInterlockClosed;
          break;
        case 10:
          host.board.needed_inputs ^= random(2) ? Inputs::kMirrorsGood : Inputs::kLaserGood;
          break;
        case 11:
        case 12:
          host.board.needed_inputs = kNeededInputs;
          ask(request(tg_HostMessage_clear_fault_tag));
          break;
        case 13:
          host.answers_heartbeats = host.credits = false;
          break;
        case 14:
          host.answers_heartbeats = host.credits = true;
          break;
        case 15:
        case 16: {
          tg_HostMessage laser = request(tg_HostMessage_laser_set_tag);
          laser.body.laser_set.on = random(4) != 0;
          ask(laser);
          break;
        }
        case 17: {
          tg_HostMessage jog = request(tg_HostMessage_jog_tag);
          jog.body.jog = {static_cast<tg_AxisName>(random(3)),
                          static_cast<int32_t>(random(200'000)) - 100'000};
          ask(jog);
          break;
        }
        case 18:
          ask(request(tg_HostMessage_self_test_tag));
          break;
        case 19: {
          tg_HostMessage galvo = request(tg_HostMessage_move_galvo_tag);
          galvo.body.move_galvo = {static_cast<int32_t>(random(400'000)) - 200'000, 1'000};
          ask(galvo);
          break;
        }
        case 20:
          ask(request(tg_HostMessage_calibration_commit_tag));
          break;
        case 21:
          // Rubbish, and the 00 that ends it.
          for (uint32_t left = random(300); left > 0; --left) {
            host.board.to_machine.push_back(static_cast<uint8_t>(random(256)));
          }
          host.board.to_machine.push_back(0);
          break;
        default: {
          // Any request at all but those after which the firmware is gone.
          const uint32_t tag =
              std::next(kRequestNames.begin(), random(static_cast<uint32_t>(kRequestNames.size())))->second;
          if (tag == tg_HostMessage_reboot_tag || tag == tg_HostMessage_enter_bootloader_tag) break;
          ask(request(static_cast<pb_size_t>(tag)));
          break;
        }
      }
      host.controller->on_interlock();
      ASSERT_FALSE(host.board.laser && !(host.board.needed_inputs & Inputs::kInterlockClosed));
      host.controller->poll();
      check();
      if (testing::Test::HasFatalFailure()) return;
      host.run(0.001 * random(400));
      times_aimed += host.board.laser && host.ask(tg_HostMessage_get_status_tag).body.status.aiming;
      if (testing::Test::HasFatalFailure()) return;
    }
    host.run(0.3);
    for (const uint32_t id : asked)
      ASSERT_EQ(host.times_replied[id], 1u) << "seed " << seed << ", request " << id;
    answered += static_cast<uint32_t>(asked.size());
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
  EXPECT_GT(times_aimed, 20u);
  EXPECT_GT(answered, 3000u);
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
