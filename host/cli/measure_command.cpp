// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/inspect_options.hpp"
#include "host/cli/plan_options.hpp"
#include "host/cli/scan_options.hpp"
#include "host/measure/measure_part.hpp"

namespace tetragauge::cli {
namespace {

constexpr const char* kScanFile = "scan.ply";  // in the folder of the report

struct MeasureArguments {
  InputOptions input;
  ScanArguments scan;
  PlanArguments plan;
  InspectArguments inspect;
  int rounds = ImproveOptions{}.rounds;
  double budget_s = 0;

  void add(CLI::App& command) {
    scan.add(command);
    plan.add(command);
    input.add_model(command);
    input.add_unit(command);
    inspect.add(command);
    command
        .add_option("--rounds", rounds,
                    "Most rounds of going back to what is in doubt; 0: the first scan is judged as it is")
        ->check(CLI::Range(0, 100))
        ->capture_default_str();
    command
        .add_option("--budget", budget_s,
                    "Most time of the machine for all rounds, s; as long as they take unless given")
        ->check(CLI::Range(1.0, 1e6))
        ->type_name("S");
  }

  MeasureOptions options(std::optional<ScanPlan> given) const {
    MeasureOptions out;
    out.plan = std::move(given);
    out.improve.rounds = rounds;
    out.improve.budget_s = budget_s;
    out.improve.plan = plan.options;
    out.improve.plan.pitch_mm = scan.default_plan.pitch_mm;
    out.improve.inspect = inspect.inspect;
    return out;
  }
};

// One part: from the machine to the report. The exit code; after a round that broke off, its error: the
// report is there all the same.
Result<int> measure_one(const Console& console, MeasureArguments& arguments) {
  const std::string scan_path = (std::filesystem::path(arguments.inspect.out) / kScanFile).string();
  if (Status status = arguments.plan.check(); !status) return status.error();
  if (Status status = arguments.scan.begin(scan_path); !status) return status.error();
  std::vector<std::string> inputs = arguments.scan.input_files();
  inputs.push_back(arguments.input.model);
  if (Status status = arguments.inspect.prepare_folder(console, inputs, {kScanFile}); !status)
    return status.error();
  Result<Solid> model = arguments.input.read_model(console);
  if (!model) return model.error();
  Result<Tolerances> tolerances = arguments.inspect.read_limits(*model);
  if (!tolerances) return tolerances.error();
  Result<std::optional<ScanPlan>> given = arguments.scan.given_plan();
  if (!given) return given.error();

  MeasureOptions options = arguments.options(std::move(*given));
  bool said = false;
  options.keep_scan = [&](const Scan& scan, const ScanCounts& counts) {
    if (!said) console.say(counts_text(counts));
    said = true;
    return arguments.scan.keep(scan);
  };
  std::optional<PartMeasurement> part;
  const Status done = arguments.scan.in_session(console, [&](Link& link, const ScanOptions& scan) -> Status {
    Result<PartMeasurement> measured = measure_part(link, *model, *tolerances, options, scan);
    if (!measured) return measured.error();
    part = std::move(*measured);
    return Done{};
  });
  if (!done) return done.error();
  Result<int> code = arguments.inspect.report(console, part->run, std::span(&part->scan, 1), {scan_path},
                                              *model, arguments.input.model, *tolerances, &part->story);
  if (!code || !part->interruption) return code;
  Error error = *part->interruption;
  error.message += "\nre-measuring was broken off; the report in " + arguments.inspect.out +
                   " is judged from what was measured before";
  return error;
}

}  // namespace

void add_measure(CLI::App& app, Console& console, Run& run) {
  auto arguments = std::make_shared<MeasureArguments>();
  CLI::App* command =
      add_command(app, console, "measure",
                  "The main job: scan with a machine, inspect, go back to what is in doubt, report");
  arguments->add(*command);
  command->callback([arguments, &console, &run] {
    run = [arguments, &console] { return measure_one(console, *arguments); };
  });
}

}  // namespace tetragauge::cli
