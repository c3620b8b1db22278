// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/cli/command.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "host/base/whole_file.hpp"
#include "host/cli/check_outputs.hpp"
#include "host/report/print_text.hpp"

namespace tetragauge::cli {

const char* const kVersion = "tetragauge " TETRAGAUGE_VERSION;

void Console::begin_stage(const std::string& words) const {
  end_stage();
  if (quiet || ::isatty(STDERR_FILENO) == 0) return;
  const std::string text = words + " ...";
  std::fputs(text.c_str(), stderr);
  *stage_length_ = text.size();
}

void Console::end_stage() const {
  if (*stage_length_ > 0) std::fprintf(stderr, "\r%s\r", std::string(*stage_length_, ' ').c_str());
  *stage_length_ = 0;
}

void Console::say(const std::string& line) const {
  end_stage();
  if (quiet) return;
  // Else a terminal breaks it in the middle of a word.
  const bool is_terminal = ::isatty(STDERR_FILENO) == 1;
  std::fputs(is_terminal ? wrapped(line).c_str() : (line + "\n").c_str(), stderr);
}

void Console::print(const std::string& text) const {
  end_stage();
  if (json != "-" && !keeps_stdout) std::fwrite(text.data(), 1, text.size(), stdout);
}

Status Console::put_json(const nlohmann::ordered_json& value) const {
  if (json.empty()) return Done{};
  const std::string text = value.dump(2) + "\n";
  if (json != "-") return write_whole_file(json, text);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return flush_stdout();
}

void hold_standard_descriptors() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(fd, F_GETFD) >= 0) continue;
    // open() takes the lowest free number, which is this one.
    if (::open("/dev/null", fd == STDOUT_FILENO ? O_RDONLY : O_RDWR) != fd) return;
  }
}

Status flush_stdout() {
  const bool failed_before = std::ferror(stdout) != 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && !failed_before) return Done{};
  const std::string why = flushed ? "" : std::string(": ") + std::strerror(errno);
  return bad_input("cannot write to standard output" + why + "; the output is incomplete");
}

CLI::App* add_command(CLI::App& app, Console& console, const std::string& name, const std::string& what) {
  CLI::App* command = app.add_subcommand(name, what);
  command->add_flag("--quiet,-q", console.quiet, "No progress on stderr");
  command->add_option("--threads", console.threads, "Threads to use (0: all); results do not depend on it")
      ->check(CLI::Range(0, 1024));
  command->add_option("--json", console.json, "Write the result as JSON to FILE, or - for stdout")
      ->type_name("FILE")
      ->check(not_empty());
  command->set_version_flag("--version", kVersion);
  return command;
}

}  // namespace tetragauge::cli
