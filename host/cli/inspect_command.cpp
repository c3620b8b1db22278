// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/inspect_options.hpp"

namespace tetragauge::cli {

void add_inspect(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    std::vector<std::string> scans;
    InspectArguments inspect;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = add_command(app, console, "inspect", "Scans and model in, verdict out");
  options->input.add_scans(*command, options->scans);
  options->input.add_model(*command);
  options->input.add_unit(*command);
  options->inspect.add(*command);
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      const InputOptions& input = options->input;
      std::vector<std::string> inputs = options->scans;
      inputs.push_back(input.model);
      if (Status status = options->inspect.prepare_folder(console, inputs); !status) return status.error();
      Result<Solid> model = input.read_model(console);
      if (!model) return model.error();
      Result<Tolerances> tolerances = options->inspect.read_limits(*model);
      if (!tolerances) return tolerances.error();
      std::vector<Scan> scans;
      for (const std::string& path : options->scans) {
        Result<Scan> scan = input.read_scan(console, path);
        if (!scan) return scan.error();
        scans.push_back(std::move(*scan));
      }
      return options->inspect.run(console, scans, options->scans, *model, input.model, *tolerances);
    };
  });
}

}  // namespace tetragauge::cli
