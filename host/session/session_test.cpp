// SPDX-License-Identifier: GPL-3.0-or-later
// Sessions with the emulated machine: they repeat exactly, over whatever line, and end clearly when something
// breaks.
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <fstream>
#include <thread>

#include "host/scan/scan_file.hpp"
#include "host/session/default_plan.hpp"
#include "host/session/emulated_session.hpp"

namespace tetragauge {
namespace {

using std::chrono::steady_clock;

std::string scan_bytes(const EmulatedMachineOptions& options, const ScanOptions& scan = {}) {
  auto session = start_session(options);
  EXPECT_TRUE(session) << session.error().message;
  if (!session) return "";
  const auto measured = run_scan(*session->link, plan_all_round(4, 16), scan);
  EXPECT_TRUE(measured) << measured.error().message;
  return measured ? scan_to_ply(measured->scan) : "";
}

TEST(Session, RunsRepeatByteForByte) {
  const auto part = box_file();
  const std::string first = scan_bytes({.part = part, .seed = 7});
  EXPECT_GT(first.size(), 10'000u);
  EXPECT_TRUE(first == scan_bytes({.part = part, .seed = 7}));
  EXPECT_FALSE(first == scan_bytes({.part = part, .seed = 8}));
}

TEST(Session, PaceDoesNotChangeTheScan) {
  const auto part = box_file();
  EXPECT_TRUE(scan_bytes({.part = part}) == scan_bytes({.part = part, .speed = "40"}));
}

TEST(Session, SecondScanOfOneMachineIsTheSame) {
  auto session = start_session({.part = box_file()});
  ASSERT_TRUE(session) << session.error().message;
  const auto first = run_scan(*session->link, plan_all_round(5, 8));
  const auto second = run_scan(*session->link, plan_all_round(5, 8));
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(scan_to_ply(first->scan) == scan_to_ply(second->scan));
}

TEST(Session, DropsTheTableAndCountsIt) {
  auto session = start_session({.part = box_file()});
  ASSERT_TRUE(session) << session.error().message;
  const auto dropped = run_scan(*session->link, plan_all_round(5, 16));
  ASSERT_TRUE(dropped) << dropped.error().message;
  const auto kept = run_scan(*session->link, plan_all_round(5, 16), {.keep_table = true});
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_GT(dropped->counts.table_points, 100u);
  EXPECT_EQ(kept->counts.table_points, 0u);
  EXPECT_EQ(kept->scan.size(), dropped->scan.size() + dropped->counts.table_points);
  const auto points_at = [](const Scan& scan, double below_mm) {
    return std::count_if(scan.points.begin(), scan.points.end(),
                         [&](const Vec3& p) { return p.z() < below_mm; });
  };
  EXPECT_EQ(points_at(dropped->scan, 0.1), 0);
  EXPECT_GT(points_at(kept->scan, 0.1), 100);
}

TEST(Session, PartOutsideTheVolumeIsBadInput) {
  const auto session =
      start_session({.part = temporary_file("long.csg", "cube(size = [101, 10, 10], center = false);\n")});
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().kind, ErrorKind::bad_input);
  EXPECT_NE(session.error().message.find("working volume"), std::string::npos) << session.error().message;
  const auto shifted = start_session({.part = box_file(), .place = "0,0,0,31,0,0"});
  ASSERT_FALSE(shifted);
  EXPECT_EQ(shifted.error().kind, ErrorKind::bad_input);
}

TEST(Session, EmulatorPassesOnWhatIsWrong) {
  const auto missing = start_session({.part = "/nonexistent/part.csg"});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::bad_input);
  const auto world = temporary_file("bad_world.json", R"({"camera_1": {"shift": [0, 0, 0]}})");
  const auto unknown = start_session({.part = box_file(), .world = world});
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("shift_mm"), std::string::npos) << unknown.error().message;
  EXPECT_EQ(start_session({.part = box_file(), .speed = "fast"}).error().kind, ErrorKind::usage);
}

TEST(Session, UnpluggedInTheMiddleIsAnErrorAtOnce) {
  auto session = start_session({.part = box_file()});
  ASSERT_TRUE(session) << session.error().message;
  ScanOptions options;
  options.on_progress = [&](const ScanProgress& progress) {
    if (progress.view == 3) ::kill(session->machine->process(), SIGKILL);
  };
  const auto start = steady_clock::now();
  const auto measured = run_scan(*session->link, plan_all_round(4, 16), options);
  ASSERT_FALSE(measured);
  EXPECT_EQ(measured.error().kind, ErrorKind::machine);
  EXPECT_LT(steady_clock::now() - start, std::chrono::seconds(10));
}

TEST(Session, FrozenMachineIsAnErrorInBoundedTime) {
  auto session = start_session({.part = box_file()}, {.silence = std::chrono::seconds(1)});
  ASSERT_TRUE(session) << session.error().message;
  const pid_t emulator = session->machine->process();
  ScanOptions options;
  options.on_progress = [&](const ScanProgress& progress) {
    if (progress.view == 2) ::kill(emulator, SIGSTOP);
  };
  const auto measured = run_scan(*session->link, plan_all_round(4, 16), options);
  ASSERT_FALSE(measured);
  EXPECT_EQ(measured.error().kind, ErrorKind::machine);
  EXPECT_NE(measured.error().message.find("stopped answering"), std::string::npos)
      << measured.error().message;
  const auto start = steady_clock::now();
  session->machine.reset();  // still stopped: it cannot end by itself
  EXPECT_LT(steady_clock::now() - start, std::chrono::seconds(5));
  EXPECT_NE(::kill(emulator, 0), 0);
}

// After 5 s of wall time the host counts as silent; the firmware pauses with the laser off, and goes on when
// it is back.
TEST(Session, SilentHostPausesTheMachineAndBreaksNothing) {
  const auto part = box_file();
  auto session = start_session({.part = part});
  ASSERT_TRUE(session) << session.error().message;
  bool slept = false;
  bool paused = false, machine_said_so = false;
  ScanOptions options;
  options.log = [&](const std::string& line) {
    paused = paused || line.find("the machine had paused") != std::string::npos;
    machine_said_so = machine_said_so || line == "the machine warns: the host was silent: paused";
  };
  options.on_progress = [&](const ScanProgress& progress) {
    if (slept || progress.view != 2) return;
    slept = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5800));
  };
  const auto measured = run_scan(*session->link, plan_all_round(4, 16), options);
  ASSERT_TRUE(measured) << measured.error().message;
  EXPECT_TRUE(paused);
  EXPECT_TRUE(machine_said_so);
  EXPECT_TRUE(scan_to_ply(measured->scan) == scan_bytes({.part = part}));
}

TEST(Session, StoppedByTheUserTheMachineIsReadyAgain) {
  auto session = start_session({.part = box_file()});
  ASSERT_TRUE(session) << session.error().message;
  std::atomic<bool> stop{false};
  ScanOptions options;
  options.stop = &stop;
  options.on_progress = [&](const ScanProgress& progress) { stop = progress.view >= 2; };
  const auto measured = run_scan(*session->link, plan_all_round(4, 16), options);
  ASSERT_FALSE(measured);
  EXPECT_NE(measured.error().message.find("laser is off"), std::string::npos);
  const auto status = session->link->status();
  ASSERT_TRUE(status) << status.error().message;
  EXPECT_TRUE(status->state == tg_State_STATE_READY || status->state == tg_State_STATE_ARMED)
      << status->state;
  // And it measures as if nothing had been.
  const auto again = run_scan(*session->link, plan_all_round(8, 8));
  EXPECT_TRUE(again) << again.error().message;
}

TEST(Session, EmulatorEndsWithTheHostThatStartedIt) {
  const auto part = box_file();
  struct Started {
    pid_t emulator = -1;
    char device[100] = {};
  };
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const pid_t host = ::fork();
  if (host == 0) {
    const auto session = start_session({.part = part});
    Started started;
    if (session) {
      started.emulator = session->machine->process();
      session->machine->device().copy(started.device, sizeof started.device - 1);
    }
    (void)!::write(ends[1], &started, sizeof started);
    ::kill(::getpid(), SIGKILL);
  }
  Started started;
  ASSERT_EQ(::read(ends[0], &started, sizeof started), static_cast<ssize_t>(sizeof started));
  const pid_t emulator = started.emulator;
  ASSERT_GT(emulator, 0);
  ::waitpid(host, nullptr, 0);
  const auto running = [](pid_t process) {
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    std::string line;
    // Whoever adopts it reaps it; a zombie has ended too.
    return std::getline(file, line) && line.find(") Z") == std::string::npos;
  };
  ASSERT_TRUE(running(::getpid()));
  for (int i = 0; i < 100 && running(emulator); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(running(emulator)) << "1 s after its host";
  const auto folder = std::filesystem::path(std::string(started.device).substr(5)).parent_path();
  EXPECT_NE(folder.string().find("tetragauge-"), std::string::npos) << folder;
  EXPECT_FALSE(std::filesystem::exists(folder)) << folder;
}

TEST(Session, EmptyTableIsSaidClearly) {
  auto session = start_session(
      {.part = temporary_file("grain.csg", "cube(size = [0.2, 0.2, 0.05], center = false);\n")});
  ASSERT_TRUE(session) << session.error().message;
  const auto plan = default_plan(*session->link);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().kind, ErrorKind::machine);
  EXPECT_NE(plan.error().message.find("no part on the table"), std::string::npos) << plan.error().message;
}

}  // namespace
}  // namespace tetragauge
