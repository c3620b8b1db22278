// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmarks of the main job on the emulated machine: `plan`, `rounds`, `measure`, `time`.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/measure/measure_part.hpp"
#include "host/session/emulated_machine.hpp"
#include "tests/bench/machine_parts.hpp"

namespace tetragauge::bench {

struct BenchOptions {
  std::vector<std::string> parts;  // names; empty: all that the benchmark is about
  size_t points = 100;
  int seeds = 20, rounds = ImproveOptions{}.rounds;
  double pitch_mm = 1;
  uint64_t seed = 1;  // of the emulated machine's noise
};

// An emulated machine with a part on it.
struct BenchMachine {
  std::unique_ptr<EmulatedMachine> machine;
  std::unique_ptr<Link> link;
};
struct BenchSetup {
  std::string csg, place, faults;
  uint64_t seed = 1;
};
// Ends the program with the error's words when it does not start: nothing can be measured then.
BenchMachine start_machine(const BenchSetup& setup);
// A folder of this program's own, removed at its end.
const std::filesystem::path& work_folder();
Solid solid_of(const std::string& csg);
bool is_chosen(const BenchOptions& options, const MachinePart& part);

// Each prints a table; 0 when all is as it must be.
int bench_plan(const BenchOptions& options);
int bench_rounds(const BenchOptions& options);
int bench_measure(const BenchOptions& options);
int bench_time(const BenchOptions& options);

}  // namespace tetragauge::bench
