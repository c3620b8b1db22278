// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/check_outputs.hpp"
#include "host/cli/scan_options.hpp"

namespace tetragauge::cli {

void add_scan(CLI::App& app, Console& console, Run& run) {
  struct Options {
    ScanArguments scan;
    std::string out;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "scan", "A scan session with a machine: points with rays and sigma");
  options->scan.add(*command);
  command->add_option("--out", options->out, "Scan file to write")
      ->required()
      ->type_name("SCAN.ply")
      ->check(not_empty());
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      if (Status status = options->scan.begin(options->out); !status) return status.error();
      if (Status status = check_outputs(console, {options->out}, options->scan.input_files()); !status)
        return status.error();
      Result<MeasuredScan> measured = options->scan.measure(console);
      if (!measured) return measured.error();
      if (Status status = console.put_json(counts_json(measured->counts)); !status) return status.error();
      console.say(options->out + ": " + std::to_string(measured->scan.size()) + " points");
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
