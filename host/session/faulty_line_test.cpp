// SPDX-License-Identifier: GPL-3.0-or-later
// A line that flips, drops, doubles and delays bytes both ways, and is cut for seconds at a time: the scan is
// the clean one, byte for byte.
#include <gtest/gtest.h>

#include "host/scan/scan_file.hpp"
#include "host/session/emulated_session.hpp"

namespace tetragauge {
namespace {

ScanPlan half_round() {
  ScanPlan plan = plan_all_round(3);
  plan.views.resize(4);
  return plan;
}

struct Scanned {
  std::string bytes;
  uint32_t bad_frames_at_host = 0, bad_frames_at_machine = 0;
  uint64_t machine_clock_us = 0;
};

Scanned scan_with(const std::string& board, const std::string& faults) {
  auto session = start_session({.board = board, .part = box_file(), .faults = faults});
  EXPECT_TRUE(session) << faults << ": " << session.error().message;
  if (!session) return {};
  const auto measured = run_scan(*session->link, half_round());
  EXPECT_TRUE(measured) << faults << ": " << measured.error().message;
  const auto status = session->link->status();
  EXPECT_TRUE(status) << faults << ": " << status.error().message;
  if (!measured || !status) return {};
  return {scan_to_ply(measured->scan), session->link->bad_frames(), status->bad_frames, status->clock_us};
}

class FaultyLine : public testing::TestWithParam<std::string> {};

TEST_P(FaultyLine, CostsNoBeam) {
  const std::string board = GetParam();
  if (!can_run(board))
    GTEST_SKIP() << "no image of " << board << ": run script/setup, which installs what builds it";
  const Scanned clean = scan_with(board, "");
  ASSERT_GT(clean.bytes.size(), 50'000u);
  EXPECT_EQ(clean.bad_frames_at_host + clean.bad_frames_at_machine, 0u);
  uint32_t bad_frames_at_machine = 0;  // of all: the few bytes that go there meet no fault in some scans
  // What QEMU runs takes ten times as long.
  const int seeds = board == "emulated" ? 10 : 2;
  for (int seed = 1; seed <= seeds; ++seed) {
    const std::string faults =
        "link_flip=1e-4,link_drop=1e-4,link_duplicate=1e-4,link_delay=1e-4,link_cut@7s+2s,link_cut@12s+2s,"
        "seed=" +
        std::to_string(seed);
    const Scanned scanned = scan_with(board, faults);
    EXPECT_TRUE(scanned.bytes == clean.bytes) << faults;
    // Else nothing would be shown.
    EXPECT_GT(scanned.bad_frames_at_host, 0u) << faults;
    EXPECT_GT(scanned.machine_clock_us, 14'000'000u) << faults;
    bad_frames_at_machine += scanned.bad_frames_at_machine;
  }
  EXPECT_GT(bad_frames_at_machine, 0u);
}

INSTANTIATE_TEST_SUITE_P(Boards, FaultyLine, testing::ValuesIn(kEmulatedBoards),
                         [](const auto& board) { return board.param; });

}  // namespace
}  // namespace tetragauge
