// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/teach/teach.hpp"

#include <cstdlib>
#include <string_view>

#include "host/cli/check_outputs.hpp"
#include "host/cli/machine_options.hpp"
#include "host/teach/draw_screen.hpp"

namespace tetragauge::cli {
namespace {

std::string_view environment(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

TerminalColours terminal_colours(bool ascii) {
  const std::string_view term = environment("TERM");
  if (ascii || std::getenv("NO_COLOR") || term.empty() || term == "dumb") return TerminalColours::none;
  const std::string_view depth = environment("COLORTERM");
  return depth == "truecolor" || depth == "24bit" ? TerminalColours::full : TerminalColours::palette;
}

std::string footer() {
  std::string text = "Keys:\n";
  for (const std::string& line : key_table()) text += "  " + line + "\n";
  return text +
         "\nWhere PLAN.json exists already, teaching goes on from it. Beside it come PLAN.preview.png (the\n"
         "last preview) and PLAN.view-N.png. `scan --plan PLAN.json` measures what was taught.";
}

}  // namespace

void add_teach(CLI::App& app, Console& console, Run& run) {
  struct Options {
    MachineArguments machine;
    std::string out;
    bool ascii = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      add_command(app, console, "teach", "Jog the machine from the keyboard, preview, keep views: a plan");
  options->machine.add(*command);
  command->add_option("--out", options->out, "Plan file to write, or to go on with")
      ->required()
      ->type_name("PLAN.json")
      ->check(not_empty());
  command->add_flag("--ascii", options->ascii, "Pictures of characters, without colours");
  command->footer(footer());
  command->callback([options, &console, &run] {
    run = [options, &console]() -> Result<int> {
      if (Status status = options->machine.check(); !status) return status.error();
      const std::vector<std::string> inputs{options->machine.emulated.part.string(),
                                            options->machine.emulated.world.string()};
      if (Status status = check_outputs(console, {options->out}, inputs); !status) return status.error();
      OpenMachine machine;
      TeachOptions teaching;
      teaching.plan_file = options->out;
      teaching.colours = terminal_colours(options->ascii);
      teaching.log = [&](const std::string& line) { console.say(line); };
      teaching.connect = [&]() -> Result<Link*> {
        // The old ones first: a serial port opens once.
        machine.link.reset();
        machine.emulated.reset();
        Result<OpenMachine> opened = options->machine.open();
        if (!opened) return opened.error();
        machine = std::move(*opened);
        return machine.link.get();
      };
      Result<Taught> taught = teach(teaching);
      if (!taught) return taught.error();
      if (Status status = console.put_json(
              {{"schema", "tetragauge/teach/1"}, {"views", taught->views}, {"saved", taught->saved}});
          !status)
        return status.error();
      console.say(taught->saved ? options->out + ": " + std::to_string(taught->views) + " views"
                                : "no plan was saved");
      return 0;
    };
  });
}

}  // namespace tetragauge::cli
