// SPDX-License-Identifier: GPL-3.0-or-later
// The options that name a machine, real or emulated, and the scan session they lead to.
#pragma once

#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/session/default_plan.hpp"
#include "host/session/emulated_machine.hpp"
#include "host/session/run_scan.hpp"

namespace tetragauge::cli {

struct MachineArguments {
  std::string port, plan;
  EmulatedMachineOptions emulated;
  DefaultPlanOptions default_plan;
  bool keep_table = false;

  void add(CLI::App& command);

  // The files named; empty names are files not given.
  std::vector<std::string> input_files() const;
  // Usage errors that can be known before a machine is touched.
  Status check() const;
  // Opens the machine, scans, closes it. Ctrl-C aborts the machine, laser off, and there is no scan.
  Result<MeasuredScan> scan(const Console& console) const;
};

nlohmann::ordered_json counts_json(const ScanCounts& counts);

}  // namespace tetragauge::cli
