// SPDX-License-Identifier: GPL-3.0-or-later
// What fails on the machine while it scans, and what the machine then does: read from its trace, in its own
// time.
#include <gtest/gtest.h>

#include <charconv>
#include <fstream>
#include <map>
#include <sstream>

#include "host/scan/scan_file.hpp"
#include "host/session/emulated_session.hpp"

namespace tetragauge {
namespace {

constexpr int64_t kSample_ns = 30'000, kMs = 1'000'000;

struct TraceLine {
  int64_t time_ns = 0;
  std::string what, value;
};

std::vector<TraceLine> read_trace(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string text;
  std::getline(file, text);
  EXPECT_EQ(text, "time_ns,what,value");
  std::vector<TraceLine> lines;
  while (std::getline(file, text)) {
    std::istringstream words(text);
    TraceLine line;
    std::string time;
    std::getline(words, time, ',');
    std::getline(words, line.what, ',');
    std::getline(words, line.value);
    std::from_chars(time.data(), time.data() + time.size(), line.time_ns);
    lines.push_back(line);
  }
  return lines;
}

struct Outcome {
  std::optional<MeasuredScan> measured;
  std::string error;  // empty: none
  std::vector<TraceLine> trace;

  // The first such line at or after `from_ns`.
  const TraceLine* find(const std::string& what, const std::string& value, int64_t from_ns = 0) const {
    for (const TraceLine& line : trace) {
      if (line.time_ns >= from_ns && line.what == what && line.value == value) return &line;
    }
    return nullptr;
  }
  bool laser_on_at(int64_t time_ns) const {
    bool on = false;
    for (const TraceLine& line : trace) {
      if (line.time_ns > time_ns) break;
      if (line.what == "laser") on = line.value == "on";
    }
    return on;
  }
};

class MachineFaults : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!can_run(GetParam()))
      GTEST_SKIP() << "no image of " << GetParam() << ": run script/setup, which installs what builds it";
  }

  static Outcome run_with(const std::string& faults);
  // Of the board under test.
  static const Outcome& clean();
  // An instant at which the laser is on, in the middle of the third view.
  static int64_t laser_on_ns();
};

Outcome MachineFaults::run_with(const std::string& faults) {
  static int count = 0;
  const auto trace = temporary_file("trace" + std::to_string(++count) + ".csv", "");
  Outcome run;
  {
    auto session = start_session({.board = GetParam(), .part = box_file(), .faults = faults, .trace = trace});
    EXPECT_TRUE(session) << faults << ": " << session.error().message;
    if (!session) return run;
    auto measured = run_scan(*session->link, plan_all_round(5, 16));
    if (measured) {
      run.measured = std::move(*measured);
    } else {
      run.error = measured.error().message;
    }
  }
  run.trace = read_trace(trace);
  return run;
}

const Outcome& MachineFaults::clean() {
  static std::map<std::string, Outcome> runs;
  if (!runs.contains(GetParam())) runs[GetParam()] = run_with("");
  return runs[GetParam()];
}

int64_t MachineFaults::laser_on_ns() {
  const TraceLine* view = clean().find("view", "3");
  const TraceLine* on = clean().find("laser", "on", view->time_ns + 300 * kMs);
  return on->time_ns + 50'000;
}

std::string at(int64_t time_ns) {
  return "@" + std::to_string(time_ns / 1000) + "us";
}

// The machine stops in `fault`, the laser goes off within `laser_ns` of `time_ns` and never on again.
void expect_fault(const Outcome& run, const std::string& fault, int64_t time_ns, int64_t laser_ns) {
  EXPECT_FALSE(run.measured);
  const TraceLine* line = run.find("fault", fault);
  ASSERT_NE(line, nullptr) << fault << "; " << run.error;
  EXPECT_GE(line->time_ns, time_ns);
  EXPECT_FALSE(run.laser_on_at(time_ns + laser_ns));
  EXPECT_EQ(run.find("laser", "on", time_ns + laser_ns), nullptr);
}

TEST_P(MachineFaults, TraceAndScanRepeatByteForByte) {
  ASSERT_TRUE(clean().measured) << clean().error;
  const Outcome again = run_with("");
  ASSERT_TRUE(again.measured);
  EXPECT_TRUE(scan_to_ply(again.measured->scan) == scan_to_ply(clean().measured->scan));
  ASSERT_EQ(again.trace.size(), clean().trace.size());
  for (size_t i = 0; i < again.trace.size(); ++i) {
    ASSERT_EQ(again.trace[i].time_ns, clean().trace[i].time_ns) << i;
    ASSERT_EQ(again.trace[i].value, clean().trace[i].value) << i;
  }
}

TEST_P(MachineFaults, InterlockTurnsTheLaserOffWithinOneSample) {
  const int64_t time_ns = laser_on_ns() / 1000 * 1000;
  const Outcome run = run_with("interlock" + at(time_ns));
  EXPECT_TRUE(run.laser_on_at(time_ns - 1));
  expect_fault(run, "INTERLOCK", time_ns, kSample_ns);
  EXPECT_NE(run.find("state", "ESTOP"), nullptr);
  EXPECT_NE(run.error.find("interlock"), std::string::npos) << run.error;
}

TEST_P(MachineFaults, LostHeartbeatsTurnTheLaserOffWithinHalfASecond) {
  const int64_t time_ns = laser_on_ns() / 1000 * 1000;
  const Outcome run = run_with("link_cut" + at(time_ns) + "+2s");
  ASSERT_TRUE(run.measured) << run.error;
  const TraceLine* paused = run.find("state", "PAUSED");
  ASSERT_NE(paused, nullptr);
  EXPECT_GT(paused->time_ns, time_ns);
  EXPECT_LE(paused->time_ns, time_ns + 500 * kMs);
  EXPECT_FALSE(run.laser_on_at(time_ns + 500 * kMs));
  const TraceLine* on_again = run.find("laser", "on", time_ns + 500 * kMs);
  ASSERT_NE(on_again, nullptr);
  EXPECT_GE(on_again->time_ns, time_ns + 2000 * kMs);
  EXPECT_TRUE(scan_to_ply(run.measured->scan) == scan_to_ply(clean().measured->scan));
}

TEST_P(MachineFaults, FailingLaserIsAFault) {
  const int64_t time_ns = laser_on_ns() / 1000 * 1000;
  const Outcome run = run_with("laser_failing" + at(time_ns));
  // Seen at the end of the burst under way.
  expect_fault(run, "LASER", time_ns, 64 * kSample_ns);
}

TEST_P(MachineFaults, DarkLaserGivesNoPointsAndNoFault) {
  const int64_t time_ns = laser_on_ns();
  const Outcome run = run_with("laser_dark" + at(time_ns) + "+200ms");
  ASSERT_TRUE(run.measured) << run.error;
  const auto weak = [](const Outcome& r) { return r.measured->counts.rejected[tg_RejectReason_REJECT_WEAK]; };
  EXPECT_GT(weak(run), weak(clean()));
  EXPECT_EQ(run.measured->counts.beams, clean().measured->counts.beams);
}

TEST_P(MachineFaults, StuckMirrorIsAFault) {
  for (const char* mirror : {":a", ":b"}) {
    const int64_t time_ns = laser_on_ns();
    const Outcome run = run_with("mirror_stuck" + at(time_ns) + mirror);
    // A row of the raster takes some 40 ms: mirror b is off its target by then.
    expect_fault(run, "MIRROR", time_ns / 1000 * 1000, 100 * kMs);
  }
}

TEST_P(MachineFaults, ChannelOnItsRailIsASignalFault) {
  const int64_t time_ns = laser_on_ns();
  const Outcome run = run_with("adc_rail" + at(time_ns) + ":2y1");
  // 100 beams of some 2 ms.
  expect_fault(run, "SIGNAL", time_ns / 1000 * 1000, 300 * kMs);
}

TEST_P(MachineFaults, ChannelShortlyOnItsRailCostsBeamsOnly) {
  const int64_t time_ns = laser_on_ns();
  const Outcome run = run_with("adc_rail" + at(time_ns) + "+50ms:1x2,adc_rail" + at(time_ns) + "+50ms:2x2");
  ASSERT_TRUE(run.measured) << run.error;
  const auto refused = [](const Outcome& r) {
    return r.measured->counts.rejected[tg_RejectReason_REJECT_SATURATED] +
           r.measured->counts.rejected[tg_RejectReason_REJECT_AMBIENT];
  };
  EXPECT_GT(refused(run), refused(clean()) + 10);
  EXPECT_EQ(run.measured->counts.beams, clean().measured->counts.beams);
}

TEST_P(MachineFaults, AmbientFlashIsRejectedAndSpoilsNothing) {
  const int64_t time_ns = laser_on_ns();
  const Outcome run = run_with("flash" + at(time_ns) + "+100ms:9uA");
  ASSERT_TRUE(run.measured) << run.error;
  const MeasuredScan &flashed = *run.measured, &dark = *clean().measured;
  EXPECT_GT(flashed.counts.rejected[tg_RejectReason_REJECT_AMBIENT], 20u);
  EXPECT_EQ(dark.counts.rejected[tg_RejectReason_REJECT_AMBIENT], 0u);
  EXPECT_EQ(flashed.counts.beams, dark.counts.beams);
  // Every point that is left is the clean scan's.
  size_t k = 0;
  for (const Vec3& point : flashed.scan.points) {
    while (k < dark.scan.size() && dark.scan.points[k] != point) ++k;
    ASSERT_LT(k, dark.scan.size());
  }
}

TEST_P(MachineFaults, LimitSwitchStopsAMove) {
  // On its way up to the first view.
  const int64_t time_ns = clean().find("state", "SCANNING")->time_ns / 1000 * 1000 + 200 * kMs;
  const Outcome run = run_with("limit_high" + at(time_ns));
  expect_fault(run, "LIMIT", time_ns, 0);
  EXPECT_NE(run.error.find("limit"), std::string::npos) << run.error;
}

INSTANTIATE_TEST_SUITE_P(Boards, MachineFaults, testing::ValuesIn(kEmulatedBoards),
                         [](const auto& board) { return board.param; });

}  // namespace
}  // namespace tetragauge
