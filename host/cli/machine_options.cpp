// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/machine_options.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>

#include "host/geometry/parse_number.hpp"
#include "host/geometry/rigid_transform.hpp"

namespace tetragauge::cli {
namespace {

// By RejectReason (protocol/machine.proto).
constexpr const char* kReasons[] = {"", "weak", "saturated", "ambient", "inconsistent", "outside the volume",
                                    "", ""};

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

// While it lives, Ctrl-C and SIGTERM ask the session to stop instead of killing it with the laser on.
class StopOnSignal {
 public:
  StopOnSignal() {
    struct sigaction action {};
    action.sa_handler = [](int) { stop_requested = true; };
    sigaction(SIGINT, &action, &old_interrupt_);
    sigaction(SIGTERM, &action, &old_terminate_);
  }
  ~StopOnSignal() {
    sigaction(SIGINT, &old_interrupt_, nullptr);
    sigaction(SIGTERM, &old_terminate_, nullptr);
  }
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

 private:
  struct sigaction old_interrupt_ {
  }, old_terminate_{};
};

std::string counts_text(const ScanCounts& counts) {
  std::string text = std::to_string(counts.beams) + " beams: " + std::to_string(counts.points) + " points, " +
                     std::to_string(counts.table_points) + " on the table dropped";
  for (size_t reason = 0; reason < counts.rejected.size(); ++reason) {
    if (counts.rejected[reason] == 0) continue;
    text += ", " + std::to_string(counts.rejected[reason]) + " " + kReasons[reason];
  }
  char rate[80];
  if (counts.machine_time_s > 0) {
    std::snprintf(rate, sizeof rate, "; %.0f s of the machine's time, %.0f beams/s", counts.machine_time_s,
                  static_cast<double>(counts.beams) / counts.machine_time_s);
    text += rate;
  }
  return text;
}

}  // namespace

void MachineArguments::add(CLI::App& command) {
  auto* port_option =
      command.add_option("--port", port, "Machine: /dev/ttyX, unix:PATH or tcp:HOST:PORT")->type_name("DEV");
  auto* part_option =
      command.add_option("--emulated", emulated.part, "Emulated machine: model of the part as really made")
          ->type_name("PART")
          ->excludes(port_option);
  command
      .add_option("--place", emulated.place,
                  "How the emulated part stands: turned (degrees), then shifted (mm)")
      ->type_name("RX,RY,RZ,TX,TY,TZ")
      ->needs(part_option);
  command.add_option("--seed", emulated.seed, "Seed of the emulated machine's noise")
      ->capture_default_str()
      ->needs(part_option);
  command.add_option("--world", emulated.world, "True geometry and noise of the emulated machine (JSON)")
      ->type_name("FILE")
      ->needs(part_option);
  command.add_option("--speed", emulated.speed, "Time of the emulated machine: max, or 1 for real time")
      ->check(CLI::IsMember({"max", "1"}))
      ->capture_default_str()
      ->needs(part_option);
  auto* plan_option =
      command.add_option("--plan", plan, "Scan plan (JSON); without one a survey finds the part")
          ->type_name("P.json");
  command.add_option("--pitch", default_plan.pitch_mm, "Spacing of the beams without a plan, mm")
      ->check(CLI::Range(0.05, 20.0))
      ->capture_default_str()
      ->excludes(plan_option);
  command.add_flag("--keep-table", keep_table, "Keep points on the table's top");
}

std::vector<std::string> MachineArguments::input_files() const {
  return {plan, emulated.part.string(), emulated.world.string()};
}

Status MachineArguments::check() const {
  if (port.empty() == emulated.part.empty()) {
    return usage_error("name the machine: --port DEV for a real one, or --emulated PART");
  }
  if (port.starts_with("tcp:")) {
    const std::string number = port.substr(port.rfind(':') + 1);
    const auto value = parse_number<int>(number);
    if (!value || *value < 1 || *value > 65535) {
      return usage_error("--port " + port + ": must be tcp:HOST:PORT with a port from 1 to 65535");
    }
  }
  if (!emulated.place.empty()) {
    Result<RigidTransform> pose = parse_pose(emulated.place, "--place");
    if (!pose) return pose.error();
  }
  return Done{};
}

Result<MeasuredScan> MachineArguments::scan(const Console& console) const {
  StopOnSignal stop_on_signal;
  std::optional<ScanPlan> given;
  if (!plan.empty()) {
    Result<ScanPlan> read = read_plan(plan);
    if (!read) return read.error();
    given = std::move(*read);
  }
  std::unique_ptr<EmulatedMachine> machine;
  std::string device = port;
  if (!emulated.part.empty()) {
    Result<std::unique_ptr<EmulatedMachine>> started = EmulatedMachine::start(emulated);
    if (!started) return started.error();
    machine = std::move(*started);
    device = machine->device();
  }
  Result<std::unique_ptr<Transport>> transport = open_transport(device);
  if (!transport) return transport.error();
  Result<std::unique_ptr<Link>> link = Link::connect(std::move(*transport));
  if (!link) return link.error();

  const bool on_terminal = !console.quiet && ::isatty(STDERR_FILENO);
  bool line_open = false;
  const auto end_line = [&] {
    if (std::exchange(line_open, false)) std::fputs("\n", stderr);
  };
  ScanOptions options;
  options.keep_table = keep_table;
  options.stop = &stop_requested;
  if (machine) options.seed = emulated.seed;
  options.log = [&](const std::string& line) {
    end_line();
    console.say(line);
  };
  if (on_terminal) {
    options.on_progress = [&](const ScanProgress& progress) {
      std::fprintf(stderr, "\rview %zu of %zu, %zu of %zu beams, %zu points, %zu rejected ", progress.view,
                   progress.views, progress.beams, progress.beams_planned, progress.points,
                   progress.rejected);
      line_open = true;
    };
  }
  if (!given) {
    Result<ScanPlan> laid_out = tetragauge::default_plan(**link, default_plan, options);
    end_line();
    if (!laid_out) return laid_out.error();
    given = std::move(*laid_out);
  }
  Result<MeasuredScan> measured = run_scan(**link, *given, options);
  end_line();
  if (!measured) return measured.error();
  console.say(counts_text(measured->counts));
  return measured;
}

nlohmann::ordered_json counts_json(const ScanCounts& counts) {
  nlohmann::ordered_json rejected = nlohmann::ordered_json::object();
  for (size_t reason = 1; reason < counts.rejected.size(); ++reason)
    if (*kReasons[reason] != '\0') rejected[kReasons[reason]] = counts.rejected[reason];
  return {{"schema", "tetragauge/scan/1"},
          {"beams", counts.beams},
          {"points", counts.points},
          {"table_points_dropped", counts.table_points},
          {"rejected", rejected},
          {"unsettled", counts.unsettled},
          {"one_camera", counts.one_camera},
          {"machine_time_s", counts.machine_time_s}};
}

}  // namespace tetragauge::cli
