// SPDX-License-Identifier: GPL-3.0-or-later
// The options of a scan, and the session they lead to: a scan file, with its journal beside it meanwhile.
//
//   ScanArguments scan;
//   scan.add(*command);
//   scan.begin("scan.ply");                      // with --resume: takes up what was asked for then
//   auto measured = scan.measure(console);       // scan.ply is there
#pragma once

#include "host/cli/machine_options.hpp"
#include "host/session/default_plan.hpp"
#include "host/session/scan_journal.hpp"

namespace tetragauge::cli {

struct ScanArguments {
  MachineArguments machine;
  std::string plan, part_serial, operator_name;
  DefaultPlanOptions default_plan;
  bool keep_table = false, resume = false;

  void add(CLI::App& command);

  // Errors that can be known before a machine is touched: contradicting options, a journal of an interrupted
  // scan that nobody resumes, one of another scan.
  Status begin(const std::filesystem::path& out);
  // The files named; empty names are files not given. Known after begin().
  std::vector<std::string> input_files() const;
  // Opens the machine, scans, writes the scan, closes the machine. After an error, and after Ctrl-C (machine
  // aborted, laser off), what was measured is kept in the journal.
  Result<MeasuredScan> measure(const Console& console);

 private:
  // What a resumed scan has to know (scan_order.cpp).
  nlohmann::ordered_json order() const;
  Status take_order(const nlohmann::ordered_json& order);
  Result<MeasuredScan> measure_with_journal(const Console& console);
  Result<MeasuredScan> measure_on(OpenMachine& opened, std::optional<ScanPlan> given, const Console& console);
  Error with_way_to_go_on(Error error) const;

  CLI::App* command_ = nullptr;
  std::filesystem::path out_;
  std::string start_time_;
  std::unique_ptr<ScanJournal> journal_;
};

nlohmann::ordered_json counts_json(const ScanCounts& counts);

}  // namespace tetragauge::cli
