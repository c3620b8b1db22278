// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/inspect_options.hpp"

namespace tetragauge::cli {

void add_inspect(CLI::App& app, Console& console, Run& run) {
  struct Options {
    InputOptions input;
    InspectArguments inspect;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = add_command(app, console, "inspect", "Scan and model in, verdict out");
  options->input.add_scan(*command);
  options->input.add_model(*command);
  options->input.add_unit(*command);
  options->inspect.add(*command);
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      const InputOptions& input = options->input;
      if (Status status = options->inspect.prepare_folder(console, {input.scan, input.model}); !status)
        return status.error();
      Result<Solid> model = input.read_model(console);
      if (!model) return model.error();
      Result<Tolerances> tolerances = options->inspect.read_limits(*model);
      if (!tolerances) return tolerances.error();
      Result<Scan> scan = input.read_scan(console);
      if (!scan) return scan.error();
      return options->inspect.run(console, *scan, input.scan, *model, input.model, *tolerances);
    };
  });
}

}  // namespace tetragauge::cli
