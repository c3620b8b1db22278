// SPDX-License-Identifier: GPL-3.0-or-later
// The command line: one file per command, each of which adds itself to the app and says what to run.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "host/base/result.hpp"

namespace tetragauge::cli {

// What holds for every command. stdout is data, stderr is progress and log.
struct Console {
  bool quiet = false;
  std::string json;           // FILE or "-" for stdout; empty: no JSON
  int threads = 0;            // 0: all
  bool keeps_stdout = false;  // print() says nothing: many results, of which the sum is printed

  // Progress and log, one line on stderr; nothing with --quiet.
  void say(const std::string& line) const;
  // What is being done now: stands on the terminal until the next stage, line or result; nothing elsewhere.
  void begin_stage(const std::string& words) const;
  void end_stage() const;
  // Text a person reads on stdout; nothing when stdout carries the JSON. main() sees whether it got there.
  void print(const std::string& text) const;
  // Writes `value` where --json asked for it, whole.
  Status put_json(const nlohmann::ordered_json& value) const;

 private:
  std::shared_ptr<size_t> stage_length_ = std::make_shared<size_t>(0);  // of the text that stands there
};

// Standard descriptors that came closed are taken, so that no file or socket opened later gets their numbers
// and what is printed; a closed stdout still fails when written to.
void hold_standard_descriptors();

// An error when anything written to stdout so far was lost.
Status flush_stdout();

// Runs a command; the result is the exit code.
using Run = std::function<Result<int>()>;

// Adds a subcommand with --quiet, --threads, --json and --version.
CLI::App* add_command(CLI::App& app, Console& console, const std::string& name, const std::string& what);

extern const char* const kVersion;

void add_measure(CLI::App& app, Console& console, Run& run);
void add_scan(CLI::App& app, Console& console, Run& run);
void add_plan(CLI::App& app, Console& console, Run& run);
void add_simulate(CLI::App& app, Console& console, Run& run);
void add_reconstruct(CLI::App& app, Console& console, Run& run);
void add_faces(CLI::App& app, Console& console, Run& run);
void add_model(CLI::App& app, Console& console, Run& run);
void add_match(CLI::App& app, Console& console, Run& run);
void add_inspect(CLI::App& app, Console& console, Run& run);
void add_history(CLI::App& app, Console& console, Run& run);
void add_teach(CLI::App& app, Console& console, Run& run);

}  // namespace tetragauge::cli
