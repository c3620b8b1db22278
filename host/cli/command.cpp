// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/command.hpp"

#include <cstdio>

#include "host/base/whole_file.hpp"

namespace tetragauge::cli {

const char* const kVersion = "tetragauge " TETRAGAUGE_VERSION;

void Console::say(const std::string& line) const {
  if (!quiet) std::fprintf(stderr, "%s\n", line.c_str());
}

void Console::print(const std::string& text) const {
  if (json != "-") std::fwrite(text.data(), 1, text.size(), stdout);
}

Status Console::put_json(const nlohmann::ordered_json& value) const {
  if (json.empty()) return Done{};
  const std::string text = value.dump(2) + "\n";
  if (json != "-") return write_whole_file(json, text);
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    return internal_error("standard output was closed before the JSON was written");
  }
  return Done{};
}

CLI::App* add_command(CLI::App& app, Console& console, const std::string& name, const std::string& what) {
  CLI::App* command = app.add_subcommand(name, what);
  command->add_flag("--quiet,-q", console.quiet, "No progress on stderr");
  command->add_option("--threads", console.threads, "Threads to use (0: all); results do not depend on it")
      ->check(CLI::Range(0, 1024));
  command->add_option("--json", console.json, "Write the result as JSON to FILE, or - for stdout")
      ->type_name("FILE");
  command->set_version_flag("--version", kVersion);
  return command;
}

}  // namespace tetragauge::cli
