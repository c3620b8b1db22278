// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/machine_bench.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace tetragauge::bench {
namespace {

[[noreturn]] void give_up(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message.c_str());
  std::exit(1);
}

std::filesystem::path file_of(const std::string& csg) {
  const std::filesystem::path path = work_folder() / "part.csg";
  std::ofstream(path, std::ios::binary) << csg;
  return path;
}

}  // namespace

const std::filesystem::path& work_folder() {
  struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("tetragauge-bench-" + std::to_string(::getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() { std::filesystem::remove_all(path); }
  };
  static const Folder folder;
  return folder.path;
}

BenchMachine start_machine(const BenchSetup& setup) {
  EmulatedMachineOptions options;
  options.part = file_of(setup.csg);
  options.place = setup.place;
  options.faults = setup.faults;
  options.seed = setup.seed;
  BenchMachine out;
  auto machine = EmulatedMachine::start(options);
  if (!machine) give_up(machine.error());
  out.machine = std::move(*machine);
  auto transport = open_transport(out.machine->device());
  if (!transport) give_up(transport.error());
  auto link = Link::connect(std::move(*transport), kEmulatedLink);
  if (!link) give_up(link.error());
  out.link = std::move(*link);
  return out;
}

Solid solid_of(const std::string& csg) {
  Result<Solid> solid = read_solid(file_of(csg));
  if (!solid) give_up(solid.error());
  return std::move(*solid);
}

bool is_chosen(const BenchOptions& options, const MachinePart& part) {
  return options.parts.empty() ||
         std::find(options.parts.begin(), options.parts.end(), part.name) != options.parts.end();
}

}  // namespace tetragauge::bench

int main(int argc, char** argv) {
  using namespace tetragauge::bench;
  CLI::App app{"Benchmarks of the main job on the emulated machine."};
  app.require_subcommand(1);
  BenchOptions options;
  int code = 0;
  const auto add = [&](const char* name, const char* what, int (*run)(const BenchOptions&)) {
    CLI::App* command = app.add_subcommand(name, what);
    command->add_option("--part", options.parts, "Only these parts");
    command->callback([&, run] { code = run(options); });
    return command;
  };
  add("plan", "Planned scans against the fixed views all round: time, coverage, what is unseen", bench_plan)
      ->add_option("--points", options.points, "Points asked for of every face")
      ->capture_default_str();
  add("rounds", "Parts with slots: what is in doubt before and after re-measurement", bench_rounds)
      ->add_option("--seed", options.seed, "Of the emulated machine's noise")
      ->capture_default_str();
  CLI::App* measure =
      add("measure", "Good and bad parts by many seeds: verdicts, equal reports, faults of the line",
          bench_measure);
  measure->add_option("--seeds", options.seeds, "Seeds of every part")->capture_default_str();
  CLI::App* time = add("time", "How long the host itself works on a main job, by stage", bench_time);
  time->add_option("--pitch", options.pitch_mm, "Spacing of the beams, mm")->capture_default_str();
  time->add_option("--rounds", options.rounds, "Most rounds of re-measurement")->capture_default_str();
  std::string out;
  CLI::App* parts = app.add_subcommand("parts", "Writes the parts, good and bad, into a folder");
  parts->add_option("--out", out, "The folder")->required()->type_name("DIR");
  parts->callback([&] {
    std::filesystem::create_directories(out);
    for (const MachinePart& part : machine_parts()) {
      std::ofstream(std::filesystem::path(out) / (part.name + ".csg")) << part.good;
      std::ofstream(std::filesystem::path(out) / (part.name + ", bad.csg")) << part.bad;
    }
  });
  CLI11_PARSE(app, argc, argv);
  return code;
}
