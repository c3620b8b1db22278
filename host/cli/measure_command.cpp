// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/inspect_options.hpp"
#include "host/cli/scan_options.hpp"

namespace tetragauge::cli {
namespace {

constexpr const char* kScanFile = "scan.ply";  // in the folder of the report

}  // namespace

void add_measure(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    ScanArguments scan;
    InspectArguments inspect;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "measure", "The main job: scan with a machine, inspect, report");
  options->scan.add(*command);
  options->input.add_model(*command);
  options->input.add_unit(*command);
  options->inspect.add(*command);
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      const std::string scan_path = (std::filesystem::path(options->inspect.out) / kScanFile).string();
      if (Status status = options->scan.begin(scan_path); !status) return status.error();
      std::vector<std::string> inputs = options->scan.input_files();
      inputs.push_back(options->input.model);
      if (Status status = options->inspect.prepare_folder(console, inputs, {kScanFile}); !status)
        return status.error();
      Result<Solid> model = options->input.read_model(console);
      if (!model) return model.error();
      Result<Tolerances> tolerances = options->inspect.read_limits(*model);
      if (!tolerances) return tolerances.error();
      Result<MeasuredScan> measured = options->scan.measure(console);
      if (!measured) return measured.error();
      return options->inspect.run(console, std::span(&measured->scan, 1), {scan_path}, *model,
                                  options->input.model, *tolerances);
    };
  });
}

}  // namespace tetragauge::cli
